// Ingest: reads a motion file, converts it to the database's markers and stores it.
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
  std::string skeleton_file_name;  // empty: none
  core::FileFormat format = core::FileFormat::kBvh;
  std::string label;
  std::string subject;
  core::ReadOptions conventions;
  std::optional<double> leg_length_m;
  std::string clip_id;  // empty: from file_name
  std::string file_bytes;
  std::string skeleton_bytes;
  // See storage::NewClip.
  std::function<storage::AuditRecord(const storage::ClipRecord&)> audit;
};

// Minimum frames of a clip: velocities need two frames.
inline constexpr int kMinClipFrames = 2;

// Returns the source report of a clip record: the reader's report, then notes on the processing.
std::string ReportOf(const core::SourceReport& report, const std::vector<std::string>& notes);

// Reads and stores a clip. Calls `stored` with it while the database cannot be deleted. Returns the
// clip when it is durable. On errors nothing has changed, except for errors of `stored`. Codes:
// INVALID_ARGUMENT (file, line and expectation), ALREADY_EXISTS, NOT_FOUND (the database was
// deleted), RESOURCE_EXHAUSTED (the clip is too long, needs too much memory or exceeds a quota),
// CANCELLED, and those of the store. Checks for cancellation before it stores anything: if a sender
// dies, the end of its stream looks like the end of the file.
absl::StatusOr<storage::ClipRecord> IngestClip(
    storage::MotionStore& store, LiveDatabase& database, IngestFile file,
    const EngineOptions& options, const core::ParallelFor& parallel, const WorkOptions& terms,
    const std::function<absl::Status(const storage::ClipRecord&)>& stored);

}  // namespace motiondb::server
