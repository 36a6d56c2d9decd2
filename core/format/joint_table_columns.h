// The meaning of the columns of a robot's joint table.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/csv_rows.h"
#include "core/format/urdf_reader.h"

namespace motiondb::core {

enum class AngleUnit { kRadians, kDegrees };

// A column of values of a degree of freedom, or of a mimic joint.
struct JointColumn {
  int column = 0;
  int dof = -1;                       // of the skeleton; of a mimic joint: its master's
  const MimicJoint* mimic = nullptr;  // of the robot; null: not a mimic joint
  std::optional<AngleUnit> unit;      // stated by the column's name; nothing: not stated
};

enum class TableLayout {
  kMotiondb,   // as from WriteJointTable
  kBonesSeed,  // Frame, root_translateX ..., root_rotateX ..., NAME_dof ...
  kPlain,      // no header: x y z, quaternion, joints, as in the LAFAN1 retargeting dataset
};

struct JointTableColumns {
  TableLayout layout = TableLayout::kPlain;
  std::optional<int> time;
  std::optional<int> frame;
  std::array<int, 3> position = {-1, -1, -1};  // x y z
  std::vector<int> rotation;  // x y z w of a quaternion; or angles about the fixed x, y and z axes
  std::optional<double> metres_per_unit;  // of the position, stated by the names
  std::vector<JointColumn> joints;
  std::vector<std::string> names;  // of all columns, for messages
  std::vector<std::string> notes;
};

// Returns the columns of a table with a header. Every moving joint of the robot needs a column,
// except for mimic joints. The error, at the line of `rows`, lists missing and unknown joints.
absl::StatusOr<JointTableColumns> ColumnsOfHeader(const CsvRows& rows,
                                                  std::span<const std::string> header,
                                                  const UrdfRobot& robot);

// Returns the columns of a table without header, with `width` columns: x y z, quaternion x y z w,
// then the moving joints in the order of the URDF file, with or without its mimic joints. The error
// is at the line of `rows`.
absl::StatusOr<JointTableColumns> ColumnsWithoutHeader(const CsvRows& rows, int width,
                                                       SourceFile urdf, const UrdfRobot& robot);

// Whether the header is that of a joint table in a known layout.
bool IsJointTableHeader(std::span<const std::string> header);

}  // namespace motiondb::core
