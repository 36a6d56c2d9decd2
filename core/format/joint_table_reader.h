// Reads tables as CSV: the joints of a robot, or points.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "core/format/csv_rows.h"
#include "core/format/motion_file.h"

namespace motiondb::core {

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
