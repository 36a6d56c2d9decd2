#include "server/translate/record_messages.h"

#include <numeric>
#include <utility>
#include <vector>

#include "core/model/label_units.h"
#include "core/motion/error.h"
#include "core/motion/glitches.h"
#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/store.pb.h"
#include "server/engine/marker_schemes.h"
#include "server/engine/model_lifecycle.h"
#include "server/translate/annotation_message.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"
#include "text/utf8.h"

namespace motiondb::server {

namespace {

constexpr int kMaxUnderived = 100;  // in a description

absl::StatusOr<core::Scaling> ScalingFrom(v1::Scaling scaling) {
  switch (scaling) {
    case v1::SCALING_UNSPECIFIED:
    case v1::SCALING_KIND:
      return core::Scaling::kKind;
    case v1::SCALING_NONE:
      return core::Scaling::kNone;
    case v1::SCALING_DIMENSION:
      return core::Scaling::kDimension;
    default:
      return FieldViolation("database.scaling",
                            "unknown scaling {}; expected none, kind or dimension",
                            static_cast<int>(scaling));
  }
}

absl::StatusOr<core::GlitchPolicy> GlitchPolicyFrom(v1::Glitches glitches) {
  switch (glitches) {
    case v1::GLITCHES_UNSPECIFIED:
    case v1::GLITCHES_REPAIR:
      return core::GlitchPolicy::kRepair;
    case v1::GLITCHES_REJECT:
      return core::GlitchPolicy::kReject;
    case v1::GLITCHES_DROP:
      return core::GlitchPolicy::kDrop;
    case v1::GLITCHES_KEEP:
      return core::GlitchPolicy::kKeep;
    default:
      return FieldViolation("database.glitches",
                            "unknown value {}; expected repair, reject, drop or keep",
                            static_cast<int>(glitches));
  }
}

v1::Glitches ToProto(core::GlitchPolicy policy) {
  switch (policy) {
    case core::GlitchPolicy::kRepair:
      return v1::GLITCHES_REPAIR;
    case core::GlitchPolicy::kReject:
      return v1::GLITCHES_REJECT;
    case core::GlitchPolicy::kDrop:
      return v1::GLITCHES_DROP;
    case core::GlitchPolicy::kKeep:
      return v1::GLITCHES_KEEP;
  }
  return v1::GLITCHES_UNSPECIFIED;
}

v1::Calibration OwnCalibration(core::UnknownCalibration unknown) {
  switch (unknown) {
    case core::UnknownCalibration::kFitted:
      return v1::CALIBRATION_OWN;
    case core::UnknownCalibration::kNotFitted:
      return v1::CALIBRATION_OLDER_VERSION;
    case core::UnknownCalibration::kOneClip:
      return v1::CALIBRATION_ONE_CLIP;
    case core::UnknownCalibration::kOneLabel:
      return v1::CALIBRATION_ONE_LABEL;
    case core::UnknownCalibration::kOneSubject:
      return v1::CALIBRATION_ONE_SUBJECT;
    case core::UnknownCalibration::kTooFewClips:
      return v1::CALIBRATION_TOO_FEW_CLIPS;
  }
  return v1::CALIBRATION_UNSPECIFIED;
}

}  // namespace

v1::Calibration ToProto(Calibration calibration, core::UnknownCalibration unknown) {
  switch (calibration) {
    case Calibration::kOwn:
      return OwnCalibration(unknown);
    case Calibration::kPrevious:
      return v1::CALIBRATION_PREVIOUS;
    case Calibration::kTypical:
      return v1::CALIBRATION_TYPICAL;
  }
  return v1::CALIBRATION_UNSPECIFIED;
}

absl::StatusOr<core::BuildSettings> ParseBuildSettings(const v1::Database& database) {
  core::BuildSettings settings;
  if (database.has_frame_rate_hz()) settings.frame_rate_hz = database.frame_rate_hz();
  if (database.has_min_frames()) settings.min_frames = database.min_frames();
  MOTIONDB_ASSIGN_OR_RETURN(settings.scaling, ScalingFrom(database.scaling()));
  MOTIONDB_ASSIGN_OR_RETURN(settings.glitches, GlitchPolicyFrom(database.glitches()));
  return settings;
}

void SetDatabaseSettings(const storage::DatabaseRecord& record, v1::Database& message) {
  message.set_name(DatabaseName(record.name));
  message.set_frame_rate_hz(record.settings.frame_rate_hz);
  message.set_min_frames(record.settings.min_frames);
  message.set_scaling(ToProto(record.settings.scaling));
  message.set_glitches(ToProto(record.settings.glitches));
  message.set_marker_set(text::ValidUtf8(record.marker_set));
  const bool own = record.marker_set != kStandardMarkerSet && record.marker_set != kSourceMarkerSet;
  if (own) message.set_marker_set_file(text::ValidUtf8(record.marker_set_text));
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
}

void SetDatabase(const storage::DatabaseRecord& record, const LiveDatabase& live,
                 v1::Database& message) {
  SetDatabaseSettings(record, message);
  if (const auto scheme = live.scheme(); scheme.ok() && *scheme != nullptr) {
    for (const std::string& marker : (*scheme)->set.markers) {
      message.add_marker_names(text::ValidUtf8(marker));
    }
  }
  const StoredAmount stored = live.stored();
  message.set_clip_count(stored.clip_count);
  message.set_frame_count(stored.frame_count);
  const ServedModel served = live.lifecycle().served();
  message.set_model_version(served.record() == nullptr ? 0 : served.record()->version);
}

void SetStatistics(const LiveDatabase& live, const Snapshot* snapshot,
                   v1::DatabaseStatistics& message) {
  message.set_name(DatabaseName(live.name()));
  message.set_frame_rate_hz(live.settings().frame_rate_hz);
  message.set_glitches(ToProto(live.settings().glitches));
  message.set_stored_clip_count(live.stored().clip_count);
  const auto underived = live.underived();
  message.set_underived_clip_count(static_cast<int>(underived.size()));
  for (const auto& [clip, reason] : underived) {
    if (message.underived_clips_size() == kMaxUnderived) break;
    v1::UnderivedClip& to = *message.add_underived_clips();
    to.set_name(ClipName(live.name(), clip));
    to.set_reason(text::ValidUtf8(reason));
  }
  if (snapshot == nullptr) return;

  const storage::ModelRecord& record = snapshot->record;
  SetModelStatistics(record, message);
  const auto& nodes = record.nodes_per_layer;
  message.set_layer_count(static_cast<int>(nodes.size()));
  message.set_node_count(std::accumulate(nodes.begin(), nodes.end(), 0));
  message.set_bottom_node_count(nodes.empty() ? 0 : nodes.back());
  message.set_model_version(record.version);
  message.set_calibration(CalibrationOf(*snapshot));

  const core::LabelUnits& units = *snapshot->model.action_units();
  std::vector<v1::LabelSummary> labels(units.labels().size());
  std::vector<int> last_clip(labels.size(), -1);
  for (const core::LabelUnit& unit : units.all()) {
    if (unit.label < 0) continue;
    v1::LabelSummary& label = labels[unit.label];
    label.set_label(units.labels()[unit.label]);
    label.set_clip_count(label.clip_count() + (last_clip[unit.label] == unit.clip ? 0 : 1));
    label.set_frame_count(label.frame_count() + unit.frame_count);
    last_clip[unit.label] = unit.clip;
  }
  for (v1::LabelSummary& label : labels) *message.add_labels() = std::move(label);
}

namespace {

// Returns the note on glitches in the report of a clip, without its prefix.
std::string GlitchNoteOf(const std::string& report) {
  const std::string mark = std::string("; ") + core::kGlitchNote;
  const std::size_t begin = report.find(mark);
  if (begin == std::string::npos) return "";
  const std::size_t from = begin + mark.size();
  return report.substr(from, report.find("; ", from) - from);
}

}  // namespace

void SetClip(const storage::ClipRecord& record, v1::Clip& message) {
  message.set_name(ClipName(record.database, record.id));
  message.set_label(record.label);
  message.set_subject(record.subject);
  message.set_file_name(record.file_name);
  message.set_format(ToProto(record.format));
  message.set_frame_count(record.frame_count);
  message.set_duration_seconds(record.duration_seconds);
  message.set_source_frame_rate_hz(record.source_frame_rate_hz);
  message.set_leg_length_m(record.leg_length_m);
  if (!record.skeleton_id.empty()) {
    message.set_skeleton(SkeletonName(record.database, record.skeleton_id));
  }
  message.set_source_report(text::ValidUtf8(record.source_report));
  message.set_glitches(text::ValidUtf8(GlitchNoteOf(record.source_report)));
  message.set_representation_version(record.representation_version);
  message.set_derive_error(text::ValidUtf8(record.derive_error));
  message.set_take(text::ValidUtf8(record.given.take));
  SetAnnotations(record, message);
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
}

void SetSkeleton(const std::string& database, const storage::SkeletonRecord& record,
                 v1::Skeleton& message) {
  message.set_name(SkeletonName(database, record.id));
  message.set_dof_count(record.skeleton.dof_count());
  for (const core::Joint& joint : record.skeleton.joints()) {
    v1::Skeleton::Joint& to = *message.add_joints();
    to.set_name(text::ValidUtf8(joint.name));
    if (joint.parent >= 0) to.set_parent_joint(joint.parent);
    to.set_offset_x_m(joint.offset_m.x());
    to.set_offset_y_m(joint.offset_m.y());
    to.set_offset_z_m(joint.offset_m.z());
    for (const core::Dof& dof : joint.dofs) {
      v1::Skeleton::Dof& to_dof = *to.add_dofs();
      to_dof.set_translation(dof.kind == core::Dof::Kind::kTranslation);
      to_dof.set_axis_x(dof.axis.x());
      to_dof.set_axis_y(dof.axis.y());
      to_dof.set_axis_z(dof.axis.z());
    }
  }
}

namespace {

v1::OperationState ToProto(storage::OperationState state) {
  switch (state) {
    case storage::OperationState::kPending:
      return v1::OPERATION_STATE_PENDING;
    case storage::OperationState::kRunning:
      return v1::OPERATION_STATE_RUNNING;
    case storage::OperationState::kSucceeded:
      return v1::OPERATION_STATE_SUCCEEDED;
    case storage::OperationState::kFailed:
      return v1::OPERATION_STATE_FAILED;
    case storage::OperationState::kCancelled:
      return v1::OPERATION_STATE_CANCELLED;
  }
  return v1::OPERATION_STATE_UNSPECIFIED;
}

v1::OperationKind ToProto(storage::OperationKind kind) {
  return kind == storage::OperationKind::kReprocess ? v1::OPERATION_KIND_REPROCESS
                                                    : v1::OPERATION_KIND_REBUILD;
}

}  // namespace

void SetSourcePoints(const core::SourcePoints& points, v1::UploadClipResponse& message) {
  message.set_mapping(text::ValidUtf8(points.mapping));
  message.set_mapping_text(text::ValidUtf8(points.mapping_text));
  for (const core::SourcePoint& point : points.points) {
    v1::SourcePoint& to = *message.add_points();
    to.set_name(text::ValidUtf8(point.name));
    if (point.parent >= 0) to.set_parent_point(point.parent);
    to.set_x_m(point.position_m[0]);
    to.set_y_m(point.position_m[1]);
    to.set_z_m(point.position_m[2]);
    for (const std::string& marker : point.markers) to.add_marker_names(text::ValidUtf8(marker));
  }
}

void SetOperation(const storage::OperationRecord& record, v1::Operation& message) {
  message.set_name(OperationName(record.id));
  message.set_database(DatabaseName(record.database));
  message.set_kind(ToProto(record.kind));
  message.set_state(ToProto(record.state));
  message.set_progress(record.progress);
  message.set_stage(record.stage);
  if (record.state == storage::OperationState::kSucceeded) {
    const std::string model =
        record.model_version > 0 ? ModelName(record.database, record.model_version) : "";
    if (record.kind == storage::OperationKind::kReprocess) {
      message.mutable_reprocess()->set_model(model);
    } else {
      message.mutable_rebuild()->set_model(model);
    }
  } else if (record.done()) {
    const bool cancelled = record.state == storage::OperationState::kCancelled;
    message.mutable_error()->set_code(cancelled ? static_cast<int>(absl::StatusCode::kCancelled)
                                                : record.error_code);
    message.mutable_error()->set_message(cancelled ? "cancelled on request"
                                                   : text::SafeText(record.error_message));
  }
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  SetTimestamp(record.update_time_us, *message.mutable_update_time());
}

namespace {

constexpr std::size_t kTextLimit = 1024;

}  // namespace

void SetCorruption(const storage::Corruption& corruption, v1::Corruption& message) {
  message.set_resource(text::ValidUtf8(text::SafeText(corruption.resource), kTextLimit));
  message.set_description(text::ValidUtf8(text::SafeText(corruption.description), kTextLimit));
}

}  // namespace motiondb::server
