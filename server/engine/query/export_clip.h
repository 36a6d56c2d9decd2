// Writes the stored motion of a clip as a file of another format.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "server/engine/work/work_options.h"
#include "storage/motion_store.h"

namespace motiondb::server {

class Engine;

// Returns INVALID_ARGUMENT, with the field, for a format that is read only.
absl::Status CheckWrittenFormat(std::string_view field, core::FileFormat format);

struct ExportedMotion {
  std::string file_name;  // id of the clip, or 'plan', with the extension of the format
  std::string bytes;
  std::vector<std::string> notes;  // what the file lacks, and the fit of the joint angles
};

// Writes the states of a clip, at the database's frame rate: as virtual markers or, in a format
// with joints, as joint angles of the clip's skeleton that fit the markers by inverse kinematics. A
// clip without a skeleton has markers only. Heavy work: see IsHeavyWork. Codes: NOT_FOUND,
// DATA_LOSS, RESOURCE_EXHAUSTED, FAILED_PRECONDITION (no marker set yet), CANCELLED;
// INVALID_ARGUMENT if the format is read only or cannot express the motion.
absl::StatusOr<ExportedMotion> ExportMotion(Engine& engine, const storage::ClipRecord& clip,
                                            core::FileFormat format, const WorkOptions& terms);

}  // namespace motiondb::server
