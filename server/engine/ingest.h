// Ingest: reads a motion file, converts it to the database's markers and stores it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/inspection/source_points.h"
#include "core/motion/execution.h"
#include "server/engine/live_database.h"
#include "server/engine/work/work_options.h"
#include "storage/motion_store.h"

namespace motiondb::server {

// Minimum frames of a clip: velocities need two frames.
inline constexpr int kMinClipFrames = 2;

// Returns the source report of a clip record: the reader's report, then notes on the processing.
std::string ReportOf(const core::SourceReport& report, const std::vector<std::string>& notes);

// Returns the skeleton file of a clip; none for a file that contains its own.
inline std::optional<core::SourceFile> SkeletonFile(const storage::ClipRecord& clip,
                                                    std::string_view skeleton_bytes) {
  if (clip.skeleton_file_name.empty()) return std::nullopt;
  return core::SourceFile{clip.skeleton_file_name, skeleton_bytes};
}

// A clip to ingest, and how.
struct IngestRequest {
  storage::NewClip clip;
  bool force = false;                    // accept an implausible body (core/format/plausibility.h)
  bool replace = false;                  // see IngestClip
  bool validate_only = false;            // store nothing
  core::SourcePoints* points = nullptr;  // set from the file; null: not wanted
  std::optional<core::MotionFile> source = {};  // see ImportBefore
};

// Whether the file of the request is read by motiondb-import.
bool NeedsImport(const IngestRequest& request);

// Reads the file of a request that NeedsImport, so that IngestClip does not wait for
// motiondb-import on a thread that other calls need. Errors of ReadSource.
absl::Status ImportBefore(IngestRequest& request, const WorkOptions& terms);

// Reads and stores a clip. The caller sets the file's bytes, the names of the files, the format,
// what was given about the file and, if it is fixed, the id; the rest is derived. Calls `stored`
// with it while the database cannot be deleted. Returns the clip when it is durable. With
// `replace`, the stored clip with the same content or the fixed id is replaced; the new one has its
// id and, if empty, its label, subject and annotations. On errors nothing has changed, except for
// errors of `stored`. Codes: INVALID_ARGUMENT (file, line and expectation), ALREADY_EXISTS, ABORTED
// (the clip to replace has changed meanwhile), NOT_FOUND (the database was deleted),
// RESOURCE_EXHAUSTED (the clip is too long, needs too much memory or exceeds a quota), CANCELLED,
// and those of the store. Checks for cancellation before it stores anything: if a sender dies, the
// end of its stream looks like the end of the file.
absl::StatusOr<storage::ClipRecord> IngestClip(
    storage::MotionStore& store, LiveDatabase& database, IngestRequest request,
    const EngineOptions& options, const core::ParallelFor& parallel, const WorkOptions& terms,
    const std::function<absl::Status(const storage::ClipRecord&)>& stored);

}  // namespace motiondb::server
