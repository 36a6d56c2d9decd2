#include "server/translate/database_message.h"

#include <cmath>
#include <map>

#include "core/motion/error.h"
#include "motiondb/v1/database.pb.h"
#include "server/engine/snapshot.h"
#include "server/translate/field_violation.h"
#include "server/translate/plain_text.h"
#include "server/translate/resource_name.h"
#include "server/translate/scaling.h"
#include "server/translate/timestamp.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

// Beyond these a setting is a mistake: motion capture ends at about 1 kHz.
constexpr double kLowestFrameRateHz = 1;
constexpr double kHighestFrameRateHz = 1000;  // the fastest that motion is captured with
constexpr int kLowestMinFrames = 2;           // one frame has no variance
constexpr int kHighestMinFrames = 1'000'000;

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
      return FieldViolation("database.scaling", "{} is no scaling", static_cast<int>(scaling));
  }
}

}  // namespace

absl::StatusOr<core::BuildSettings> SettingsFrom(const v1::Database& database) {
  core::BuildSettings settings;
  const double rate = database.frame_rate_hz();
  if (rate != 0 && !(rate >= kLowestFrameRateHz && rate <= kHighestFrameRateHz)) {
    return FieldViolation("database.frame_rate_hz", "expected {} to {}, got {}", kLowestFrameRateHz,
                          kHighestFrameRateHz, rate);
  }
  const int min_frames = database.min_frames();
  if (min_frames != 0 && (min_frames < kLowestMinFrames || min_frames > kHighestMinFrames)) {
    return FieldViolation("database.min_frames", "expected {} to {}, got {}", kLowestMinFrames,
                          kHighestMinFrames, min_frames);
  }
  if (rate > 0) settings.frame_rate_hz = rate;
  if (min_frames != 0) settings.min_frames = min_frames;
  MOTIONDB_ASSIGN_OR_RETURN(settings.scaling, ScalingFrom(database.scaling()));
  return settings;
}

absl::StatusOr<MarkerSetSetting> MarkerSetFrom(const v1::Database& database) {
  MOTIONDB_RETURN_IF_ERROR(CheckPlainLines("database.marker_set_file", database.marker_set_file()));
  auto setting = ResolveMarkerSet(database.marker_set(), database.marker_set_file());
  if (setting.ok()) return setting;
  const bool own = !database.marker_set_file().empty();
  return AtField(own ? "database.marker_set_file" : "database.marker_set", setting.status());
}

void SetDatabase(const storage::DatabaseRecord& record, const LiveDatabase& live,
                 v1::Database& message) {
  message.set_name(DatabaseName(record.name));
  message.set_frame_rate_hz(record.settings.frame_rate_hz);
  message.set_min_frames(record.settings.min_frames);
  message.set_scaling(ToProto(record.settings.scaling));
  message.set_marker_set(text::ValidUtf8(record.marker_set));
  const bool own = record.marker_set != kStandardMarkerSet && record.marker_set != kSourceMarkerSet;
  if (own) message.set_marker_set_file(text::ValidUtf8(record.marker_set_text));
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  if (const auto scheme = live.scheme(); scheme.ok() && *scheme != nullptr) {
    for (const std::string& marker : (*scheme)->set.markers) {
      message.add_marker_names(text::ValidUtf8(marker));
    }
  }
  const StoredAmount stored = live.stored();
  message.set_clip_count(stored.clip_count);
  message.set_frame_count(stored.frame_count);
  const auto snapshot = live.snapshot();
  message.set_model_version(snapshot == nullptr ? 0 : snapshot->record.version);
}

void SetDescription(const LiveDatabase& live, const Snapshot* snapshot,
                    v1::DescribeDatabaseResponse& message) {
  message.set_name(DatabaseName(live.name()));
  message.set_frame_rate_hz(live.settings().frame_rate_hz);
  message.set_stored_clip_count(live.stored().clip_count);
  if (snapshot == nullptr) return;

  const core::Model& model = snapshot->model;
  message.set_frame_count(model.frame_count());
  message.set_clip_count(static_cast<int>(model.clips().size()));
  message.set_layer_count(model.layer_count());
  message.set_node_count(model.tree().total_node_count());
  message.set_bottom_node_count(model.tree().node_count(model.layer_count()));
  for (int layer = 1; layer <= model.layer_count(); ++layer) {
    message.add_nodes_per_layer(model.tree().node_count(layer));
  }
  message.set_model_version(snapshot->record.version);
  message.set_build_seconds(model.build_seconds());
  message.set_added_clip_count(snapshot->record.added_clip_count);
  message.set_stale_share(snapshot->record.stale_share);
  message.set_dimension_count(model.marker_set().dimension_count());

  std::map<std::string, v1::LabelSummary> labels;
  for (const core::ModelClip& clip : model.clips()) {
    v1::LabelSummary& label = labels[clip.label];
    label.set_clip_count(label.clip_count() + 1);
    label.set_frame_count(label.frame_count() + clip.frame_count);
  }
  for (auto& [name, label] : labels) {
    label.set_label(name);
    *message.add_labels() = label;
  }
}

}  // namespace motiondb::server
