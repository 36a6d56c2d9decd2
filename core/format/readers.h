// The readers of ReadMotionFile, one for each format. Errors: see there. They keep no state and are
// safe to call from any thread.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// The ASF states the unit (1/length inches) and, by its format, y up. The frame rate is that of
// `options`, or of ":SAMPLES-PER-SECOND" if the AMC has it, or 120 Hz, which is reported. Joints
// are laid out as BuildAsfSkeleton says. Errors: see ReadMotionFile.
absl::StatusOr<MotionFile> ReadAmc(SourceFile file, SourceFile skeleton,
                                   const ReadOptions& options);

// BVH states neither unit nor up axis. The unit is deduced from the skeleton's stature, the up axis
// from where heads are above feet in the motion itself (zero poses may lie down), unless `options`
// give them; otherwise cm and y up are assumed. Position channels replace the joint's OFFSET, as
// Blender and MotionBuilder play them. Errors: see ReadMotionFile.
absl::StatusOr<MotionFile> ReadBvh(SourceFile file, const ReadOptions& options);

// Reads the points of files that Intel, DEC and MIPS processors wrote, with whole or real numbers;
// analog channels, and points that a program computed (angles, forces, moments, powers, scalars),
// are left out. A point marked invalid, or at exactly (0, 0, 0), is missing. The unit is
// POINT:UNITS, or deduced, or mm; the up axis is POINT:Y_SCREEN, or deduced from names, or z. A
// "subject:" before all labels is dropped. Errors name the byte offset; see also ReadMotionFile.
absl::StatusOr<MotionFile> ReadC3d(SourceFile file, const ReadOptions& options);

// TRC states unit and frame rate. The up axis is deduced from markers whose names tell head and
// feet, or else y is assumed, as OpenSim has it. An empty cell or NaN is a missing marker. Errors:
// see ReadMotionFile.
absl::StatusOr<MotionFile> ReadTrc(SourceFile file, const ReadOptions& options);

}  // namespace motiondb::core
