#include "server/translate/observation_message.h"

#include "core/motion/error.h"
#include "motiondb/v1/observe.pb.h"
#include "motiondb/v1/query.pb.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"
#include "server/translate/query_message.h"
#include "server/translate/record_messages.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {

namespace {

absl::StatusOr<Observation> FromFile(std::string field, const v1::FileObservation& message) {
  if (message.file_name().empty()) {
    return FieldViolation(field + ".file_name", "is missing");
  }
  ObservedFile file;
  MOTIONDB_ASSIGN_OR_RETURN(file.format,
                            ParseFileFormat(field, message.format(), message.file_name()));
  MOTIONDB_ASSIGN_OR_RETURN(const Conventions conventions,
                            ParseConventions(field, message.conventions()));
  file.file = {message.file_name(), message.data()};
  if (!message.skeleton_file_name().empty()) {
    file.skeleton = core::SourceFile{message.skeleton_file_name(), message.skeleton_data()};
  }
  file.conventions = conventions.read;
  file.force = conventions.force;
  return Observation{std::move(field), file, conventions.leg_length_m};
}

Observation FromMarkers(std::string field, const v1::MarkerObservation& message) {
  Observation observation{
      std::move(field),
      ObservedMarkers{{message.marker_names().begin(), message.marker_names().end()},
                      message.frame_rate_hz(),
                      {message.frame_count(), message.positions()}},
      std::nullopt};
  if (message.has_leg_length_m()) observation.leg_length_m = message.leg_length_m();
  return observation;
}

absl::StatusOr<Observation> FromJoints(std::string field, const v1::JointObservation& message,
                                       const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(MemberId id,
                            ParseSkeletonName(field + ".skeleton", message.skeleton()));
  if (id.database != database) {
    return FieldViolation(field + ".skeleton", "expected a skeleton of databases/{}, got '{}'",
                          database, message.skeleton());
  }
  return Observation{std::move(field),
                     ObservedJoints{std::move(id.id),
                                    message.frame_rate_hz(),
                                    {message.frame_count(), message.angles()},
                                    message.force()},
                     std::nullopt};
}

}  // namespace

absl::StatusOr<Observation> ParseObservation(std::string_view field, const v1::Observation& message,
                                             const std::string& database) {
  switch (message.form_case()) {
    case v1::Observation::kFile:
      return FromFile(fmt::format("{}.file", field), message.file());
    case v1::Observation::kMarkers:
      return FromMarkers(fmt::format("{}.markers", field), message.markers());
    case v1::Observation::kJoints:
      return FromJoints(fmt::format("{}.joints", field), message.joints(), database);
    case v1::Observation::FORM_NOT_SET:
      break;
  }
  return FieldViolation(field, "expected one of file, markers, joints");
}

absl::StatusOr<ObserveSetup> ParseObserveSetup(const v1::ObserveStart& start) {
  ObserveSetup setup;
  setup.marker_names.assign(start.marker_names().begin(), start.marker_names().end());
  setup.frame_rate_hz = start.frame_rate_hz();
  if (start.has_leg_length_m()) setup.leg_length_m = start.leg_length_m();
  MOTIONDB_ASSIGN_OR_RETURN(setup.options, ParseObserverOptions(start));
  setup.scope = {start.filter(), start.min_revision()};
  return setup;
}

PackedFrames FramesFrom(const v1::ObservedFrames& frames) {
  return {frames.frame_count(), frames.positions()};
}

void SetStep(const ObserveStep& step, int top_count, v1::ObserveResponse& message) {
  message.set_model_version(step.model_version);
  message.set_revision(step.revision);
  message.set_model_replaced(step.model_replaced);
  message.set_calibration(ToProto(step.calibration, step.unknown_calibration));
  message.set_late_frames(step.late_frames);
  message.set_missing_frames(step.missing_frames);
  if (!step.observed) return;
  const core::Observed& observed = *step.observed;
  message.set_frame(observed.frame);
  message.set_layer(observed.layer);
  SetState(observed.state, *message.mutable_state());
  SetLabels(observed.labels, top_count, *message.mutable_labels());
  SetTracks(observed.other_tracks, top_count, *message.mutable_other_tracks());
  if (observed.unknown_probability) message.set_unknown_probability(*observed.unknown_probability);
  message.set_familiarity(observed.familiarity);
  SetHorizons(observed.horizons, *message.mutable_horizons());
}

void SetMarkers(const core::MarkerMotion& motion, v1::MarkerObservation& message) {
  message.mutable_marker_names()->Add(motion.names.begin(), motion.names.end());
  message.set_frame_rate_hz(motion.frame_rate_hz);
  message.set_frame_count(static_cast<int>(motion.positions_m.rows()));
  AppendPacked(motion.positions_m.data(), static_cast<std::size_t>(motion.positions_m.size()),
               *message.mutable_positions());
}

}  // namespace motiondb::server
