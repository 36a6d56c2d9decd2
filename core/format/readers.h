// The readers behind ReadMotionFile, one for each format. Errors: see ReadMotionFile.
#pragma once

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

// Unit: from the ASF (1/length inches). Up axis: y, by the format. Frame rate: `options`, or
// ":SAMPLES-PER-SECOND" of the AMC, or 120 Hz, which is reported. Joints: see BuildAsfSkeleton.
absl::StatusOr<MotionFile> ReadAmc(SourceFile file, SourceFile skeleton,
                                   const ReadOptions& options);

// BVH has neither unit nor up axis. Unless `options` set them, the unit is deduced from the
// skeleton's stature, and the up axis from the positions of heads and feet in the motion (zero
// poses may lie down); defaults: cm, y up. Position channels replace the joint's OFFSET, as in
// Blender and MotionBuilder.
absl::StatusOr<MotionFile> ReadBvh(SourceFile file, const ReadOptions& options);

// Reads files of Intel, DEC and MIPS processors, with integer or real numbers. Ignores analog
// channels and computed points (angles, forces, moments, powers, scalars). A point marked invalid,
// or at exactly (0, 0, 0), is missing. Unit: POINT:UNITS, or deduced, or mm. Up axis:
// POINT:Y_SCREEN, or deduced from names, or z. Removes a "subject:" prefix that all labels share.
// Errors name the byte offset.
absl::StatusOr<MotionFile> ReadC3d(SourceFile file, const ReadOptions& options);

// Unit and frame rate: from the file. Up axis: deduced from heads and feet, or y, as in OpenSim. An
// empty cell or NaN is a missing marker.
absl::StatusOr<MotionFile> ReadTrc(SourceFile file, const ReadOptions& options);

}  // namespace motiondb::core
