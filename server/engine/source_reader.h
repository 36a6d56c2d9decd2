// Reads motion files of clips and observations: in this process, or in the sandbox of
// motiondb-import if their format or compression is risky.
#pragma once

#include <optional>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "server/engine/work/work_options.h"

namespace motiondb::server {

// Limits of one import.
inline constexpr int kImportMemoryMib = 512;
inline constexpr int kImportCpuSeconds = 30;  // at most twice as long in all

// Reads a file within the memory limit of `terms`. Codes of ReadMotionFile; also RESOURCE_EXHAUSTED
// (IMPORT_LIMIT: the import needs too much memory or time), FAILED_PRECONDITION
// (IMPORT_NOT_INSTALLED), UNAVAILABLE (no process), INTERNAL (motiondb-import failed) and
// CANCELLED. TAKE_REQUIRED: the file has several takes; metadata `takes` lists the first ones as a
// JSON array, `take_count` is their number.
absl::StatusOr<core::MotionFile> ReadSource(core::FileFormat format, core::SourceFile file,
                                            std::optional<core::SourceFile> skeleton,
                                            const core::ReadOptions& given,
                                            const WorkOptions& terms);

}  // namespace motiondb::server
