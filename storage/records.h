// What a store keeps, as plain values. Times are microseconds since the Unix epoch.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/format/file_format.h"
#include "core/format/motion_file.h"
#include "core/model/build_settings.h"
#include "core/motion/cancellation.h"
#include "core/motion/skeleton.h"
#include "core/motion/states.h"
#include "storage/access_store.h"

namespace motiondb::storage {

struct DatabaseRecord {
  std::string name;  // the id alone, without "databases/"
  core::BuildSettings settings;
  std::string marker_set;       // name of the set; "source" until the first clip names it
  std::string marker_set_text;  // a marker-set file; empty for `source` until the first clip
  std::int64_t create_time_us = 0;
};

struct ClipRecord {
  std::string database;
  std::string id;
  std::string label;
  std::string subject;
  std::string file_name;           // without folders
  std::string skeleton_file_name;  // of the ASF that came with an AMC; empty otherwise
  core::FileFormat format = core::FileFormat::kBvh;
  std::int32_t frame_count = 0;  // at the database's frame rate
  double duration_seconds = 0;
  double source_frame_rate_hz = 0;
  double leg_length_m = 0;
  std::string skeleton_id;  // empty for bare markers
  std::string source_report;
  std::uint64_t content_hash =
      0;  // of motion and skeleton bytes; tells the same file ingested twice
  std::int64_t create_time_us = 0;
  std::int64_t byte_count = 0;  // that its blobs take; told by the store

  // What the ingest was given, to derive the states again with.
  core::ReadOptions given;
  std::optional<double> given_leg_length_m;
  // That made the states (core::kRepresentationVersion).
  std::int32_t representation_version = core::kRepresentationVersion;
  // The last attempt to derive them: by which version, when, and why it failed (empty: it did not).
  // A clip that was tried by a newer version than made its states is in no model.
  std::int32_t tried_version = core::kRepresentationVersion;
  std::int64_t tried_time_us = 0;
  std::string derive_error;
};

// A clip on its way in.
struct NewClip {
  ClipRecord record;  // id: the wanted one; see MotionStore::AddClip
  bool id_is_fixed = false;
  std::string file_bytes;
  std::string skeleton_bytes;
  core::StateSequence states;  // not scaled
  std::optional<core::Skeleton> skeleton;
  std::optional<std::string> marker_set_text;  // first clip of a `source` database: its scheme
  // The entry of the record of changes that is kept in the same transaction, of the clip as stored;
  // empty: none. May be called more than once, on the thread that writes.
  std::function<AuditRecord(const ClipRecord&)> audit;
  core::Cancelled cancelled;  // as ChangeTerms has it
};

// A clip after its states were derived again from its file, or could not be.
struct DerivedClip {
  // As it was listed, but for frame_count, duration_seconds, leg_length_m, source_report and what
  // tells of the attempt.
  ClipRecord record;
  std::optional<core::StateSequence> states = std::nullopt;  // none: those that are stored stay
};

struct ClipSource {
  std::string file_bytes;
  std::string skeleton_bytes;
};

struct SkeletonRecord {
  std::string id;
  core::Skeleton skeleton;
};

// The figures of a model; kept for superseded ones too.
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
  // Of the clips and frames, those that were added after the build.
  std::int32_t added_clip_count = 0;
  std::int32_t added_frame_count = 0;
  double drift_fraction = 0;  // core::ModelDrift
};

// How the current model differs from the clips that are stored.
struct ModelStaleness {
  // Ids of clips that it does not know, ascending; but of those whose states are of another version
  // (core::kRepresentationVersion), which are in no new model.
  std::vector<std::string> missing;
  int removed = 0;    // clips that it knows and that were deleted, or have other states by now
  int outdated = 0;   // clips that it knows by states that were replaced, or of another version
  int to_derive = 0;  // stored clips that the present version has not tried to derive

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
  kRebuild = 1,   // of the model, after clips came or went
  kReprocess = 2  // the same, after all clips were derived again
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

  bool done() const { return state >= OperationState::kSucceeded; }
};

}  // namespace motiondb::storage
