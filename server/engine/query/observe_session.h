// A stream of frames and the model that evaluates it. Switches to a newer model between two
// messages. Used by one thread at a time; keeps its database and its model alive.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/observe/observer.h"
#include "server/engine/query/observation.h"
#include "server/engine/query/query.h"
#include "server/engine/query/query_memory.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

// Parameters of a stream.
struct ObserveSetup {
  std::vector<std::string> marker_names;  // empty: the database's markers
  double frame_rate_hz = 0;
  std::optional<double> leg_length_m;
  core::ObserverOptions options;
  QueryScope scope;
};

// Result of one message of frames.
struct ObserveStep {
  std::optional<core::Observed> observed;  // nullopt until both hips were seen
  int model_version = 0;
  std::int64_t revision = 0;  // of the database, that the model contains
  Calibration calibration = Calibration::kOwn;
  core::UnknownCalibration unknown_calibration = core::UnknownCalibration::kNotFitted;
  bool model_replaced = false;
  std::int64_t late_frames = 0;
  std::int64_t missing_frames = 0;
};

class ObserveSession {
 public:
  // Keeps the terms of the query for the whole stream. Names that fit no mapping are mapped
  // automatically with the first message in which a frame has all markers. INVALID_ARGUMENT naming
  // the field of the setup; RESOURCE_EXHAUSTED.
  static absl::StatusOr<std::unique_ptr<ObserveSession>> Open(Query query, ObserveSetup setup);

  ~ObserveSession() { query_.database()->AddOpenStreams(-1); }
  ObserveSession(const ObserveSession&) = delete;
  ObserveSession& operator=(const ObserveSession&) = delete;

  // Processes frames first_frame, first_frame + 1, ... (frames x 3 markers, m, world frame); see
  // core::Observer::Append. NOT_FOUND if the database was deleted, FAILED_PRECONDITION if it has no
  // clips left, RESOURCE_EXHAUSTED, INVALID_ARGUMENT if the markers cannot be mapped; also the
  // codes of the observer.
  absl::StatusOr<ObserveStep> Take(std::int64_t first_frame, const PackedFrames& positions_m);

  // Positions of the newest frame; see core::Observer::NewestPositions.
  std::optional<Eigen::RowVectorXf> NewestPositions() const {
    return observer_ != nullptr ? observer_->NewestPositions() : std::nullopt;
  }
  // With the names of the markers, also if none were given.
  const ObserveSetup& setup() const { return setup_; }
  const std::shared_ptr<LiveDatabase>& database() const { return query_.database(); }

 private:
  ObserveSession(Query query, ObserveSetup setup, Filter filter,
                 std::shared_ptr<const core::MarkerScheme> scheme,
                 std::unique_ptr<core::Observer> observer);
  // Creates the observer if a frame has all markers.
  absl::Status MapMarkers(const core::FrameMatrix& positions_m);
  // Switches to the current model and the clips that pass the filter now. Returns whether the model
  // changed.
  absl::StatusOr<bool> SwitchModel();

  Query query_;
  const ObserveSetup setup_;
  const Filter filter_;
  const std::shared_ptr<const core::MarkerScheme> scheme_;
  std::unique_ptr<core::Observer> observer_;  // null: the markers are not mapped yet
  ObserveMemory memory_;
};

}  // namespace motiondb::server
