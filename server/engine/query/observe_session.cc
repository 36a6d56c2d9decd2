#include "server/engine/query/observe_session.h"

#include <algorithm>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/error.h"

namespace motiondb::server {
namespace {

core::ObserverOptions WithMask(const ObserveSetup& setup, const Query& query) {
  core::ObserverOptions options = setup.options;
  options.mask = query.mask();
  return options;
}

}  // namespace

absl::StatusOr<std::unique_ptr<ObserveSession>> ObserveSession::Open(Query query,
                                                                     ObserveSetup setup) {
  MOTIONDB_ASSIGN_OR_RETURN(Filter filter,
                            Filter::Parse(setup.scope.filter, FilterSubject::kClips));
  MOTIONDB_ASSIGN_OR_RETURN(auto scheme, query.database()->scheme());
  if (setup.marker_names.empty()) setup.marker_names = scheme->set.markers;
  MOTIONDB_RETURN_IF_ERROR(CheckUnique("marker_names", setup.marker_names));
  MOTIONDB_RETURN_IF_ERROR(core::CheckOptions(setup.options, query.model().settings()));
  MOTIONDB_RETURN_IF_ERROR(
      query.terms().Reserve(BytesToObserve(query.model(), setup.options).kept));
  // Labels of optical markers are mapped by name; other points also need positions. Until then, the
  // set's own names stand for the markers, to check the other fields.
  const core::FrameMatrix no_frames(0, 3 * std::ssize(setup.marker_names));
  const auto fitted = core::FitScheme(
      *scheme, core::MarkerMotion{setup.marker_names, setup.frame_rate_hz, no_frames},
      core::FitFor::kQuery);
  const bool needs_positions = !fitted.ok() && scheme->set.name == core::StandardScheme().set.name;
  if (needs_positions) {
    const absl::Status status = core::CheckPointNames(setup.marker_names);
    if (!status.ok()) return core::AtField("marker_names", status);
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      auto observer,
      core::Observer::Create(query.model(), fitted.ok() ? *fitted : *scheme,
                             needs_positions ? scheme->set.markers : setup.marker_names,
                             setup.frame_rate_hz, setup.leg_length_m, WithMask(setup, query)));
  if (needs_positions) observer.reset();
  return std::unique_ptr<ObserveSession>(new ObserveSession(std::move(query), std::move(setup),
                                                            std::move(filter), std::move(scheme),
                                                            std::move(observer)));
}

ObserveSession::ObserveSession(Query query, ObserveSetup setup, Filter filter,
                               std::shared_ptr<const core::MarkerScheme> scheme,
                               std::unique_ptr<core::Observer> observer)
    : query_(std::move(query)),
      setup_(std::move(setup)),
      filter_(std::move(filter)),
      scheme_(std::move(scheme)),
      observer_(std::move(observer)),
      memory_(BytesToObserve(query_.model(), setup_.options)) {
  query_.database()->AddOpenStreams(1);
}

absl::Status ObserveSession::MapMarkers(const core::FrameMatrix& positions_m) {
  const auto is_complete = [](const auto& row) { return row.allFinite(); };
  if (std::ranges::none_of(positions_m.rowwise(), is_complete)) return absl::OkStatus();
  const auto fitted = core::FitScheme(
      *scheme_, core::MarkerMotion{setup_.marker_names, setup_.frame_rate_hz, positions_m},
      core::FitFor::kQuery);
  if (!fitted.ok()) return core::AtField("start.marker_names", fitted.status());
  MOTIONDB_ASSIGN_OR_RETURN(
      observer_,
      core::Observer::Create(query_.model(), *fitted, setup_.marker_names, setup_.frame_rate_hz,
                             setup_.leg_length_m, WithMask(setup_, query_)));
  return absl::OkStatus();
}

absl::StatusOr<bool> ObserveSession::SwitchModel() {
  const std::string& name = query_.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const auto database, query_.engine().FindDatabase(name));
  if (database != query_.database()) {
    return core::WithReason(
        "DATABASE_NOT_FOUND",
        core::NotFound("database '{}' was deleted and created again: open a new stream", name));
  }
  const SnapshotPointer before = query_.snapshot();  // the observer may use it until Replace
  MOTIONDB_ASSIGN_OR_RETURN(const bool is_changed, query_.UseCurrentModel(filter_));
  if (!is_changed) return false;
  if (observer_) MOTIONDB_RETURN_IF_ERROR(observer_->Replace(query_.model(), query_.mask()));
  memory_ = BytesToObserve(query_.model(), setup_.options);
  return query_.snapshot() != before;
}

absl::StatusOr<ObserveStep> ObserveSession::Take(std::int64_t first_frame,
                                                 const PackedFrames& positions_m) {
  const WorkOptions& terms = query_.terms();
  MOTIONDB_ASSIGN_OR_RETURN(
      const core::FrameMatrix positions,
      Unpack("frames", "positions", positions_m, 3 * static_cast<int>(setup_.marker_names.size())));
  MOTIONDB_RETURN_IF_ERROR(CheckMarkers("frames.positions", setup_.marker_names, positions));
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(memory_.kept + memory_.answer));
  ObserveStep step;
  MOTIONDB_ASSIGN_OR_RETURN(step.model_replaced, SwitchModel());
  step.model_version = query_.snapshot()->record.version;
  step.revision = query_.revision();
  step.calibration = query_.snapshot()->calibration;
  step.unknown_calibration = query_.model().recognition().unknown;
  if (observer_ == nullptr) MOTIONDB_RETURN_IF_ERROR(MapMarkers(positions));
  if (observer_ == nullptr) return step;
  if (const absl::Status appended = observer_->Append(first_frame, positions, terms.cancelled);
      !appended.ok()) {
    return core::AtField("frames", appended);
  }
  MOTIONDB_ASSIGN_OR_RETURN(step.observed, observer_->Answer(terms.cancelled));
  if (step.observed) query_.database()->CountWindow(step.observed->unknown_probability);
  step.late_frames = observer_->late_frames();
  step.missing_frames = observer_->missing_frames();
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(memory_.kept));
  return step;
}

}  // namespace motiondb::server
