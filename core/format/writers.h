// Joint motion -> files, for animators' tools and for programs that drive robots. Safe to call from
// any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/format/urdf_reader.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// The motion as BVH text in centimetres, y up, on the skeleton's own joints, in depth-first order.
// Every joint has three rotation channels, whatever its degrees of freedom, as ZXY or ZYX: the one
// that stays further from gimbal lock over the clip; angles run on beyond 180 degrees rather than
// jump. A root, and a joint that slides, has three position channels too. A joint "x_end" without
// degrees of freedom that is the only child of x is written as its end site; any other joint
// without children gets an end site that goes on in the joint's own direction. White space,
// control characters and braces in names become '_'. O(frames * joints).
//
// Read back, joints are where they were to within a micrometre a joint of the chain.
//
// INVALID_ARGUMENT if the motion has no skeleton, no frame, a frame rate out of 0.001 to 100000 Hz,
// columns other than the skeleton's degrees of freedom, or a number that is not finite.
absl::StatusOr<std::string> WriteBvh(const JointMotion& motion);

// The motion as CSV (RFC 4180, but for lines that end in LF): a header, then a line a frame.
//   time_s                               from 0
//   root_x_m, root_y_m, root_z_m         where joint 0 is in the world, z up
//   root_qx, root_qy, root_qz, root_qw   how it is turned, as a unit quaternion; the first has
//                                        qw >= 0, all others the sign nearer to the one before
//   then a column for each joint that moves, in the skeleton's order, under its plain name (rad,
//   m). A joint of several degrees of freedom has a column for each: NAME/1, NAME/2, ...
// A joint of `mimics` has the value that follows from its master's. Numbers are the shortest that
// read back to the same double. O(frames * columns).
//
// INVALID_ARGUMENT as for CheckWritable, if joint 0 is not the only root, if
// two columns would have one name, or if a mimic joint or its master is not what MimicJoint says.
absl::StatusOr<std::string> WriteJointTable(const JointMotion& motion,
                                            std::span<const MimicJoint> mimics = {});

// INVALID_ARGUMENT, beginning with `format`, if the motion has no skeleton, no frame, a frame rate
// out of 0.001 to 100000 Hz, columns other than the skeleton's degrees of freedom, or a number that
// is not finite.
absl::Status CheckWritable(std::string_view format, const JointMotion& motion);

}  // namespace motiondb::core
