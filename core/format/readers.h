// The readers behind ReadMotionFile. Errors: see ReadMotionFile.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "core/format/csv_rows.h"
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

// Reads a table in one of these layouts, one line a frame (docs/file_formats.md):
//   time_s, root_x_m ... root_qw, JOINT ...          as from WriteJointTable
//   Frame, root_translateX ... root_rotateZ, JOINT_dof ...   BONES-SEED: cm, degrees, 120 Hz
//   no header: x y z, quaternion x y z w, joints     LAFAN1 retargeting: m, rad, 30 Hz
//   time_s, NAME_x_m, NAME_y_m, NAME_z_m ...         points, as from WritePointTable
// `urdf`: the robot of a table of joints; required for that, unused otherwise. The result of a
// table of joints is a JointMotion on the skeleton of ReadUrdf, of a table of points a
// MarkerMotion.
//
// Units that neither `options` nor the header state are deduced from the robot's joint limits and
// leg length, or are those of the layout. Notes of the report state the unit of the angles, values
// outside of joint limits and of mimic joints that differ from their masters.
//
// Errors: see ReadMotionFile.
absl::StatusOr<MotionFile> ReadJointTable(SourceFile file, std::optional<SourceFile> urdf,
                                          const ReadOptions& options);

// Returns the maximum memory (bytes) that ReadJointTable uses, including its result. O(file size).
std::int64_t MaxBytesToReadJointTable(SourceFile file, std::optional<SourceFile> urdf);

// The part of ReadJointTable for points. `rows` has read the header.
absl::StatusOr<MotionFile> ReadPointTable(SourceFile file, CsvRows rows,
                                          std::span<const std::string> header,
                                          const ReadOptions& options);

}  // namespace motiondb::core
