// One stream of frames and the model that judges it: takes over a model that replaces it between
// two messages. Used by one thread at a time; holds on to its database and its model.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/observe/observer.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"

namespace motiondb::server {

// What an observer is made for.
struct ObserveSetup {
  std::vector<std::string> marker_names;
  double frame_rate_hz = 0;
  std::optional<double> leg_length_m;
  core::ObserverOptions options;
};

// What one message of frames led to.
struct ObserveStep {
  std::optional<core::Observed> observed;  // nothing until both hips were seen
  int model_version = 0;
  bool model_replaced = false;
  std::int64_t late_frames = 0;
  std::int64_t missing_frames = 0;
};

class ObserveSession {
 public:
  // Codes as core::Observer::Create.
  static absl::StatusOr<std::unique_ptr<ObserveSession>> Open(
      Engine& engine, std::shared_ptr<LiveDatabase> database,
      std::shared_ptr<const Snapshot> snapshot, ObserveSetup setup);

  ~ObserveSession() { database_->AddOpenStreams(-1); }
  ObserveSession(const ObserveSession&) = delete;
  ObserveSession& operator=(const ObserveSession&) = delete;

  // Frames as core::Observer::Append takes them. NOT_FOUND once the database is deleted,
  // FAILED_PRECONDITION once it has no clips; otherwise as the observer's functions.
  absl::StatusOr<ObserveStep> Take(std::int64_t first_frame, const core::FrameMatrix& positions_m,
                                   const core::Cancelled& cancelled);

  // That judges the frames now.
  const core::Model& model() const { return snapshot_->model; }

 private:
  ObserveSession(Engine& engine, std::shared_ptr<LiveDatabase> database,
                 std::shared_ptr<const core::MarkerScheme> scheme,
                 std::shared_ptr<const Snapshot> snapshot, std::unique_ptr<core::Observer> observer)
      : engine_(engine),
        database_(std::move(database)),
        scheme_(std::move(scheme)),
        snapshot_(std::move(snapshot)),
        observer_(std::move(observer)) {
    database_->AddOpenStreams(1);
  }
  // Whether the model is another than before.
  absl::StatusOr<bool> TakeOverModel();

  Engine& engine_;
  const std::shared_ptr<LiveDatabase> database_;
  const std::shared_ptr<const core::MarkerScheme> scheme_;
  std::shared_ptr<const Snapshot> snapshot_;
  const std::unique_ptr<core::Observer> observer_;
};

}  // namespace motiondb::server
