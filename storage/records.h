// The records of a store. Times are microseconds since the Unix epoch.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/format/file_format.h"
#include "core/format/motion_file.h"
#include "core/model/build_settings.h"
#include "core/model/label_tracks.h"
#include "core/motion/execution.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "storage/access_store.h"

namespace motiondb::storage {

struct DatabaseRecord {
  std::string name;  // the id, without "databases/"
  core::BuildSettings settings;
  std::string marker_set;       // name of the set; "source" until the first clip names it
  std::string marker_set_text;  // content of a marker-set file; empty for `source` until then
  std::int64_t create_time_us = 0;
  // A database that is created again under its name has another one. Set by the store.
  std::int64_t id = 0;
};

// A moment, as the value of a field of the user.
struct FieldTime {
  std::int64_t time_us = 0;

  bool operator==(const FieldTime&) const = default;
};

// Value of a field of the user.
using FieldValue = std::variant<std::string, double, bool, FieldTime>;
using Fields = std::map<std::string, FieldValue>;  // by name

struct ClipRecord {
  std::string database;
  std::string id;
  // Label of the segment of track kActionTrack that covers the clip; empty if there is none.
  std::string label;
  std::string subject;
  std::string file_name;           // without folders
  std::string skeleton_file_name;  // the ASF file of an AMC file; empty otherwise
  core::FileFormat format = core::FileFormat::kBvh;
  std::int32_t frame_count = 0;  // at the database's frame rate
  double duration_seconds = 0;
  double source_frame_rate_hz = 0;
  double leg_length_m = 0;
  std::string skeleton_id;  // empty for bare markers
  std::string source_report;
  // Hash of the motion and skeleton bytes; detects a file that is ingested twice.
  std::uint64_t content_hash = 0;
  std::int64_t create_time_us = 0;
  std::int64_t byte_count = 0;  // size of its blobs; set by the store

  // Conventions given on ingest, to derive the states again.
  core::ReadOptions given;
  std::optional<double> given_leg_length_m;
  // Version of the code that made the states (core::kRepresentationVersion).
  std::int32_t representation_version = core::kRepresentationVersion;
  // The last attempt to derive the states: version of the code, time, and error (empty: success). A
  // clip is in no new model if tried_version is above representation_version.
  std::int32_t tried_version = core::kRepresentationVersion;
  std::int64_t tried_time_us = 0;
  std::string derive_error;

  // Annotations of the clip, apart from its segments.
  std::string title;
  std::string description;
  std::vector<std::string> tags;  // ascending, distinct
  Fields fields;
  std::int64_t revision = 0;      // of the last change of this record; its etag. Set by the store.
  std::int64_t edit_time_us = 0;  // of the last edit; 0: none. Set by the store.
};

using core::kActionTrack;

enum class SegmentSource { kPerson = 1, kImport = 2, kSuggestion = 3 };

// A labelled time range of a clip. Segments of one track of a clip do not overlap. The segment that
// covers the clip starts at 0 and has no end.
struct SegmentRecord {
  std::string database;
  std::string clip;
  std::string id;  // unique in the clip
  std::string track = kActionTrack;
  std::string label;
  double start_seconds = 0;
  std::optional<double> end_seconds;  // none: the end of the clip
  SegmentSource source = SegmentSource::kPerson;
  double confidence = 1;
  // Set by the store:
  std::int64_t revision = 0;  // of the last change; its etag
  std::string author;         // of the last change
  std::int64_t create_time_us = 0;
  std::int64_t update_time_us = 0;
};

// A clip to add.
struct NewClip {
  ClipRecord record;  // id: the requested one; see MotionStore::AddClip
  bool id_is_fixed = false;
  std::string file_bytes;
  std::string skeleton_bytes;
  core::StateSequence states;  // unscaled
  std::optional<core::Skeleton> skeleton;
  std::optional<std::string>
      marker_set_text;  // marker set of the first clip of a `source` database
  // Segments of the clip besides that of its label.
  std::vector<SegmentRecord> segments;
  std::string author;  // of the segments; see AuditRecord::principal
  // Makes the audit entry of the stored clip, which is stored in the same transaction; empty: no
  // entry. May be called more than once, on the writer thread.
  std::function<AuditRecord(const ClipRecord&)> audit;
  core::Cancelled cancelled;     // see WriteOptions
  std::int64_t database_id = 0;  // see WriteOptions
};

// The result of an attempt to derive a clip's states from its file again.
struct DerivedClip {
  // The record as listed, with new frame_count, duration_seconds, leg_length_m, source_report,
  // representation_version, tried_version, tried_time_us and derive_error.
  ClipRecord record;
  std::optional<core::StateSequence> states = std::nullopt;  // none: the stored states stay
};

struct ClipSource {
  std::string file_bytes;
  std::string skeleton_bytes;
};

struct SkeletonRecord {
  std::string id;
  core::Skeleton skeleton;
};

// What tells a server that another one has changed a database.
struct DatabaseState {
  std::string name;
  std::int64_t id = 0;        // see DatabaseRecord
  std::int64_t revision = 0;  // of its content; see AnnotationStore
  std::int64_t stamp = 0;     // differs after each change of the content or of the marker set
};

// A server that shares the store, and where the others reach it.
struct ServerAddress {
  std::string name;     // unique
  std::string address;  // HOST:PORT
};

// The conditions for storing or dropping a model. ABORTED if one is not met: the caller computed it
// from what another server has replaced meanwhile.
struct ModelTerms {
  // Version of the current model that it replaces; 0: there is none. Empty: any.
  std::optional<std::int32_t> base_version;
  // Fencing number of the caller's build lease (MotionStore::AcquireBuildLease), which must be of
  // this database, and not lower than that of its last lease; 0: the database must never have had
  // a lease.
  std::int64_t fence = 0;
};

// The statistics of a model; also kept for former models.
struct ModelRecord {
  std::string database;
  std::int32_t version = 0;
  bool current = false;
  std::int64_t create_time_us = 0;
  double build_seconds = 0;
  std::int32_t frame_count = 0;
  std::int32_t clip_count = 0;
  std::int32_t dimension_count = 0;
  std::vector<std::int32_t> nodes_per_layer;  // layer 1 first
  // Clips and frames that were added after the build; included in the counts above.
  std::int32_t added_clip_count = 0;
  std::int32_t added_frame_count = 0;
  double drift_fraction = 0;  // core::ModelDrift
};

// Differences between the current model and the stored clips.
struct ModelStaleness {
  // Ids of stored clips that are not in the model, ascending. Without clips whose states have
  // another representation version than core::kRepresentationVersion: no new model contains them.
  std::vector<std::string> missing;
  int removed = 0;    // clips of the model that were deleted, or whose states were replaced
  int outdated = 0;   // clips of the model with replaced states, or states of another version
  int to_derive = 0;  // stored clips that this version has not tried to derive

  bool empty() const { return missing.empty() && removed == 0 && outdated == 0 && to_derive == 0; }
};

enum class OperationState {
  kPending = 1,
  kRunning = 2,
  kSucceeded = 3,
  kFailed = 4,
  kCancelled = 5
};

enum class OperationKind {
  kRebuild = 1,   // builds the model after clips were added or deleted
  kReprocess = 2  // derives all clips again, then builds the model
};

struct OperationRecord {
  std::string id;
  std::string database;
  OperationKind kind = OperationKind::kRebuild;
  OperationState state = OperationState::kPending;
  double progress = 0;
  std::string stage;
  std::int32_t model_version = 0;  // 0: none
  std::int32_t error_code = 0;     // canonical status code
  std::string error_message;
  std::int64_t create_time_us = 0;
  std::int64_t update_time_us = 0;
  std::int64_t database_id = 0;  // see WriteOptions; the store returns it

  bool done() const { return state >= OperationState::kSucceeded; }
};

}  // namespace motiondb::storage
