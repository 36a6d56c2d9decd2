// One stream of frames and the model that judges it: takes over a model that replaces it between
// two messages. Used by one thread at a time; holds on to its database and its model.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/observe/observer.h"
#include "server/engine/packed_frames.h"
#include "server/engine/query.h"
#include "server/engine/query_memory.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

// What an observer is made for.
struct ObserveSetup {
  std::vector<std::string> marker_names;  // empty: the database's markers
  double frame_rate_hz = 0;
  std::optional<double> leg_length_m;
  core::ObserverOptions options;
};

// What one message of frames led to.
struct ObserveStep {
  std::optional<core::Observed> observed;  // nothing until both hips were seen
  int model_version = 0;
  Calibration calibration = Calibration::kOwn;
  bool model_replaced = false;
  std::int64_t late_frames = 0;
  std::int64_t missing_frames = 0;
};

class ObserveSession {
 public:
  // Keeps the query's terms, for the stream. INVALID_ARGUMENT naming the field of the setup;
  // RESOURCE_EXHAUSTED.
  static absl::StatusOr<std::unique_ptr<ObserveSession>> Open(Query query, ObserveSetup setup);

  ~ObserveSession() { query_.database()->AddOpenStreams(-1); }
  ObserveSession(const ObserveSession&) = delete;
  ObserveSession& operator=(const ObserveSession&) = delete;

  // Frames (frames x 3 markers, m, world) numbered first_frame, first_frame + 1, ... as
  // core::Observer::Append takes them. NOT_FOUND once the database is deleted, FAILED_PRECONDITION
  // once it has no clips; RESOURCE_EXHAUSTED; otherwise as the observer's functions.
  absl::StatusOr<ObserveStep> Take(std::int64_t first_frame, const PackedFrames& positions_m);

 private:
  ObserveSession(Query query, std::vector<std::string> marker_names, core::ObserverOptions options,
                 std::shared_ptr<const core::MarkerScheme> scheme,
                 std::unique_ptr<core::Observer> observer);
  // Whether the model is another than before.
  absl::StatusOr<bool> TakeOverModel();

  Query query_;
  const std::vector<std::string> marker_names_;
  const core::ObserverOptions options_;
  const std::shared_ptr<const core::MarkerScheme> scheme_;
  const std::unique_ptr<core::Observer> observer_;
  ObserveMemory memory_;
};

}  // namespace motiondb::server
