#include "server/engine/observe_session.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {

absl::StatusOr<std::unique_ptr<ObserveSession>> ObserveSession::Open(Query query,
                                                                     ObserveSetup setup) {
  MOTIONDB_ASSIGN_OR_RETURN(auto scheme, query.database()->scheme());
  if (setup.marker_names.empty()) setup.marker_names = scheme->set.markers;
  MOTIONDB_RETURN_IF_ERROR(CheckUnique("marker_names", setup.marker_names));
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(setup.options, query.model().settings()));
  MOTIONDB_RETURN_IF_ERROR(
      query.terms().Reserve(BytesToObserve(query.model(), setup.options).kept));
  MOTIONDB_ASSIGN_OR_RETURN(
      auto observer,
      core::Observer::Create(query.model(), *scheme, setup.marker_names, setup.frame_rate_hz,
                             setup.leg_length_m, setup.options));
  return std::unique_ptr<ObserveSession>(
      new ObserveSession(std::move(query), std::move(setup.marker_names), setup.options,
                         std::move(scheme), std::move(observer)));
}

ObserveSession::ObserveSession(Query query, std::vector<std::string> marker_names,
                               core::ObserverOptions options,
                               std::shared_ptr<const core::MarkerScheme> scheme,
                               std::unique_ptr<core::Observer> observer)
    : query_(std::move(query)),
      marker_names_(std::move(marker_names)),
      options_(std::move(options)),
      scheme_(std::move(scheme)),
      observer_(std::move(observer)),
      memory_(BytesToObserve(query_.model(), options_)) {
  query_.database()->AddOpenStreams(1);
}

absl::StatusOr<bool> ObserveSession::SwitchModel() {
  const std::string& name = query_.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(Query current, Query::Begin(query_.engine(), name, query_.terms()));
  if (current.database() != query_.database()) {
    return core::WithReason(
        "DATABASE_NOT_FOUND",
        core::NotFound("database '{}' was deleted and created again: open a new stream", name));
  }
  if (current.snapshot() == query_.snapshot()) return false;
  MOTIONDB_RETURN_IF_ERROR(observer_->Replace(current.model()));
  query_ = std::move(current);
  memory_ = BytesToObserve(query_.model(), options_);
  return true;
}

absl::StatusOr<ObserveStep> ObserveSession::Take(std::int64_t first_frame,
                                                 const PackedFrames& positions_m) {
  const WorkOptions& terms = query_.terms();
  MOTIONDB_ASSIGN_OR_RETURN(
      const core::FrameMatrix positions,
      Unpack("frames", "positions", positions_m, 3 * static_cast<int>(marker_names_.size())));
  MOTIONDB_RETURN_IF_ERROR(CheckMarkers("frames.positions", marker_names_, positions));
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(memory_.kept + memory_.answer));
  ObserveStep step;
  MOTIONDB_ASSIGN_OR_RETURN(step.model_replaced, SwitchModel());
  if (const absl::Status appended = observer_->Append(first_frame, positions, terms.cancelled);
      !appended.ok()) {
    return core::AtField("frames", appended);
  }
  MOTIONDB_ASSIGN_OR_RETURN(step.observed, observer_->Answer(terms.cancelled));
  step.model_version = query_.snapshot()->record.version;
  step.calibration = query_.snapshot()->calibration;
  step.late_frames = observer_->late_frames();
  step.missing_frames = observer_->missing_frames();
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(memory_.kept));
  return step;
}

}  // namespace motiondb::server
