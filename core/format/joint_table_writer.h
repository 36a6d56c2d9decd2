// Joint motion -> a table of joint positions, as programs that drive robots read it. Safe to call
// from any thread.
#pragma once

#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "core/format/urdf_reader.h"
#include "core/motion/motion.h"

namespace motiondb::core {

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
// INVALID_ARGUMENT as for CheckWritable (writable_motion.h), if joint 0 is not the only root, if
// two columns would have one name, or if a mimic joint or its master is not what MimicJoint says.
absl::StatusOr<std::string> WriteJointTable(const JointMotion& motion,
                                            std::span<const MimicJoint> mimics = {});

}  // namespace motiondb::core
