// The columns of a robot's joint table, and what a table without a statement probably means:
// radians or degrees, metres or centimetres, and the order of its quaternion. That is deduced from
// the robot's joint limits and leg length.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/csv_rows.h"
#include "core/format/motion_file.h"
#include "core/format/urdf_reader.h"
#include "core/motion/matrix.h"
#include "core/motion/motion.h"

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

// Excess of a joint's limits (rad) above which an angle is not in radians. The strict one is for
// tables whose layout defines radians.
inline constexpr double kUsualExcess_rad = 1;
inline constexpr double kStrictExcess_rad = 6.5;

// Returns the unit of the hinge angles whose columns state none:
//   degrees  if at least 1 % of the angles of hinges with limits exceed them by more than `excess`
//            as radians, and at most a tenth of these exceed them as degrees;
//   radians  if the angles are within the limits as radians, and as degrees the robot would move
//            its hinges by at most 2 pi = 6.3 degrees;
//   nothing  otherwise.
// Hinges without limits count as limited to a full turn if no hinge has limits. O(values).
std::optional<AngleUnit> DeduceAngleUnit(const JointMatrix& values,
                                         const JointTableColumns& columns, const Skeleton& skeleton,
                                         double excess_rad);

// Returns the metres per unit (1, 0.01 or 0.001) for which the root is about as high above the
// floor as above its lowest joint, or nothing. `root`: frames x 3, in the file's unit, z up;
// `angles`: the motion of `skeleton`, of which the root's translations are not used.
std::optional<double> DeduceRootUnit(const JointMatrix& root, const JointMatrix& angles,
                                     const Skeleton& skeleton);

// Whether quaternions (frames x 4) are w x y z rather than x y z w: the robot is upright in at
// least 95 % of the frames, with the other order in less than half of them. `up`: the file's axis.
bool IsScalarFirst(const JointMatrix& quaternions, UpAxis up);

}  // namespace motiondb::core
