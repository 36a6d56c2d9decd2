// Converts between records of the store and messages: databases, clips, operations.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "core/inspection/source_points.h"
#include "core/tree/feature_scale.h"
#include "motiondb/v1/database.pb.h"
#include "server/engine/live_database.h"
#include "server/engine/snapshot.h"
#include "storage/records.h"
#include "storage/store_maintenance.h"

namespace motiondb::v1 {
class Clip;
class Corruption;
class Database;
class DatabaseStatistics;
class Operation;
class Skeleton;
class UploadClipResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Returns the settings of a database to create, with defaults for settings not given. Returns
// INVALID_ARGUMENT with the field, below `database`, for an unknown value.
absl::StatusOr<core::BuildSettings> ParseBuildSettings(const v1::Database& database);

// Sets the statistics that Model and DatabaseStatistics have in common. They are the stored
// values, as in `status` and in the metrics.
template <typename Message>
void SetModelStatistics(const storage::ModelRecord& record, Message& message) {
  message.set_build_seconds(record.build_seconds);
  message.set_frame_count(record.frame_count);
  message.set_clip_count(record.clip_count);
  message.mutable_nodes_per_layer()->Add(record.nodes_per_layer.begin(),
                                         record.nodes_per_layer.end());
  message.set_dimension_count(record.dimension_count);
  message.set_added_clip_count(record.added_clip_count);
  message.set_drift_fraction(record.drift_fraction);
}

void SetDatabaseSettings(const storage::DatabaseRecord& record, v1::Database& message);
void SetDatabase(const storage::DatabaseRecord& record, const LiveDatabase& live,
                 v1::Database& message);
// `snapshot` may be null.
void SetStatistics(const LiveDatabase& live, const Snapshot* snapshot,
                   v1::DatabaseStatistics& message);

// `unknown`: of the model (core::RecognitionCalibration).
v1::Calibration ToProto(Calibration calibration, core::UnknownCalibration unknown);
inline v1::Calibration CalibrationOf(const Snapshot& snapshot) {
  return ToProto(snapshot.calibration, snapshot.model.recognition().unknown);
}

inline v1::Scaling ToProto(core::Scaling scaling) {
  switch (scaling) {
    case core::Scaling::kNone:
      return v1::SCALING_NONE;
    case core::Scaling::kKind:
      return v1::SCALING_KIND;
    case core::Scaling::kDimension:
      return v1::SCALING_DIMENSION;
  }
  return v1::SCALING_UNSPECIFIED;
}

void SetClip(const storage::ClipRecord& record, v1::Clip& message);
void SetSkeleton(const std::string& database, const storage::SkeletonRecord& record,
                 v1::Skeleton& message);

void SetSourcePoints(const core::SourcePoints& points, v1::UploadClipResponse& message);

void SetOperation(const storage::OperationRecord& record, v1::Operation& message);

// Truncates the texts, because a corrupt file may have texts of any length.
void SetCorruption(const storage::Corruption& corruption, v1::Corruption& message);

}  // namespace motiondb::server
