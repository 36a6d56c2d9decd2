// Reads motiondb's own NumPy archives (core/export/writers.h).
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/npz/npz_values.h"

namespace motiondb::importer {

// Joints get three rotations each, and three translations where their local positions change.
// `rest_rotations` may be absent: no rotation. Ignores the world positions of joints, which follow
// from the local ones. Errors: see ReadNpz.
absl::StatusOr<core::MotionFile> ReadMotiondbNpz(const NpzSource& source,
                                                 const core::ReadOptions& options);

}  // namespace motiondb::importer
