// Writes joint motion to files for animation tools and robot controllers.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/format/urdf_reader.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Returns the motion as BVH text in centimetres, y up, on the skeleton's own joints, in depth-first
// order. Every joint has three rotation channels, for any degrees of freedom, in the order ZXY or
// ZYX: the one that stays further from gimbal lock in the clip. Angles continue beyond 180 degrees.
// Roots and joints with translations have three position channels too. A joint "x_end" without
// degrees of freedom that is the only child of x becomes its end site; any other joint without
// children gets an end site in the joint's own direction. White space, control characters and
// braces in names become '_'. O(frames * joints).
//
// After reading back, joint positions differ by at most a micrometre for each joint of the chain.
//
// INVALID_ARGUMENT as for CheckWritable.
absl::StatusOr<std::string> WriteBvh(const JointMotion& motion);

// Returns the motion as CSV (RFC 4180, but with LF line ends): a header, then one line for each
// frame.
//   time_s                               from 0
//   root_x_m, root_y_m, root_z_m         position of joint 0 in the world, z up
//   root_qx, root_qy, root_qz, root_qw   its rotation as a unit quaternion; the first has qw >= 0,
//                                        the others the sign nearer to the previous one
//   then a column for each moving joint, in the skeleton's order, with its name (rad, m). A joint
//   with several degrees of freedom has a column for each: NAME/1, NAME/2, ...
// The value of a joint of `mimics` follows from its master's. Numbers are the shortest that read
// back to the same double. O(frames * columns).
//
// INVALID_ARGUMENT as for CheckWritable, if joint 0 is not the only root, if two columns have the
// same name, or if a mimic joint or its master violates MimicJoint.
absl::StatusOr<std::string> WriteJointTable(const JointMotion& motion,
                                            std::span<const MimicJoint> mimics = {});

// INVALID_ARGUMENT, beginning with `format`, if the motion has no skeleton, no frame, a frame rate
// out of 0.001 to 100000 Hz, columns other than the skeleton's degrees of freedom, or a number that
// is not finite.
absl::Status CheckWritable(std::string_view format, const JointMotion& motion);

}  // namespace motiondb::core
