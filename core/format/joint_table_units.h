// What a joint table without a statement probably means: radians or degrees, metres or centimetres,
// and the order of its quaternion. Deduced from the robot's joint limits and leg length.
#pragma once

#include <optional>

#include "core/format/joint_table_columns.h"
#include "core/format/motion_file.h"
#include "core/motion/matrix.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

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
