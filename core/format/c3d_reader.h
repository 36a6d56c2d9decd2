// Reads C3D files of marker positions. Keeps no state; safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// Reads the points of files that Intel, DEC and MIPS processors wrote, with whole or real numbers;
// analog channels, and points that a program computed (angles, forces, moments, powers, scalars),
// are left out. A point marked invalid, or at exactly (0, 0, 0), is missing. The unit is
// POINT:UNITS, or deduced, or mm; the up axis is POINT:Y_SCREEN, or deduced from names, or z. A
// "subject:" before all labels is dropped. Errors name the byte offset; see also ReadMotionFile.
absl::StatusOr<MotionFile> ReadC3d(SourceFile file, const ReadOptions& options);

}  // namespace motiondb::core
