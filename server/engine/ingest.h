// Takes a motion file into a database: reads it, brings it to the database's markers and stores it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/tree/parallel.h"
#include "server/engine/live_database.h"
#include "server/engine/representation.h"
#include "storage/motion_store.h"

namespace motiondb::server {

struct IngestFile {
  std::string file_name;           // without folders
  std::string skeleton_file_name;  // empty where there is none
  core::FileFormat format = core::FileFormat::kBvh;
  std::string label;
  std::string subject;
  core::ReadOptions conventions;
  std::optional<double> leg_length_m;
  std::string clip_id;  // empty: from file_name
  std::string file_bytes;
  std::string skeleton_bytes;
  // As storage::NewClip has it.
  std::function<storage::AuditRecord(const storage::ClipRecord&)> audit;
};

// Of a clip: central differences need a frame on each side of somewhere.
inline constexpr int kFewestFrames = 2;

// What a clip's record says about its source: what the reader found out, and notes on what was
// done.
std::string ReportOf(const core::SourceReport& report, const std::vector<std::string>& notes);

// Reads and stores a clip, and calls `stored` with it before the database can be deleted. Returns
// the clip when it is durable; on any error but one of `stored` nothing has changed. Codes:
// INVALID_ARGUMENT (file, line and what was expected), ALREADY_EXISTS, NOT_FOUND (the database was
// deleted), RESOURCE_EXHAUSTED (the clip is too long, takes too much memory, or the database
// may not hold so much), CANCELLED (asked before anything is stored: the end of a stream whose
// sender died looks like the end of the file), and those of the store. Thread-safe.
absl::StatusOr<storage::ClipRecord> IngestClip(
    storage::MotionStore& store, LiveDatabase& database, IngestFile file,
    const EngineOptions& options, const core::ParallelFor& parallel, const WorkTerms& terms,
    const std::function<absl::Status(const storage::ClipRecord&)>& stored);

}  // namespace motiondb::server
