// Reads NumPy archives of the SMPL family of body models: AMASS, SMPL, SMPL-H, SMPL-X, AIST++.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "import/npz/npz_values.h"

namespace motiondb::importer {

// Whether the archive has arrays of rotations of a body model.
bool IsSmpl(const NpzArchive& archive);

// See ReadNpz. REQUIRES: IsSmpl.
absl::StatusOr<core::MotionFile> ReadSmpl(const NpzSource& source,
                                          const core::ReadOptions& options);

}  // namespace motiondb::importer
