#include "server/engine/observe_session.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<std::unique_ptr<ObserveSession>> ObserveSession::Open(
    Engine& engine, std::shared_ptr<LiveDatabase> database,
    std::shared_ptr<const Snapshot> snapshot, ObserveSetup setup) {
  MOTIONDB_ASSIGN_OR_RETURN(auto scheme, database->scheme());
  MOTIONDB_ASSIGN_OR_RETURN(
      auto observer,
      core::Observer::Create(snapshot->model, *scheme, std::move(setup.marker_names),
                             setup.frame_rate_hz, setup.leg_length_m, setup.options));
  return std::unique_ptr<ObserveSession>(new ObserveSession(
      engine, std::move(database), std::move(scheme), std::move(snapshot), std::move(observer)));
}

absl::StatusOr<bool> ObserveSession::TakeOverModel() {
  MOTIONDB_ASSIGN_OR_RETURN(const auto found, engine_.FindDatabase(database_->name()));
  if (found != database_) {
    return core::NotFound("database '{}' was deleted, and another created", database_->name());
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto current, engine_.CurrentModel(*database_));
  if (current == snapshot_) return false;
  MOTIONDB_RETURN_IF_ERROR(observer_->Replace(current->model));
  snapshot_ = std::move(current);
  return true;
}

absl::StatusOr<ObserveStep> ObserveSession::Take(std::int64_t first_frame,
                                                 const core::FrameMatrix& positions_m,
                                                 const core::Cancelled& cancelled) {
  ObserveStep step;
  MOTIONDB_ASSIGN_OR_RETURN(step.model_replaced, TakeOverModel());
  MOTIONDB_RETURN_IF_ERROR(observer_->Append(first_frame, positions_m, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(step.observed, observer_->Answer(cancelled));
  step.model_version = snapshot_->record.version;
  step.late_frames = observer_->late_frames();
  step.missing_frames = observer_->missing_frames();
  return step;
}

}  // namespace motiondb::server
