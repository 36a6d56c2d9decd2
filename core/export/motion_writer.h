// Writes motion in any format that motiondb writes, and reports what the format cannot express.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/file_format.h"
#include "core/format/urdf_reader.h"
#include "core/motion/motion.h"

namespace motiondb::core {

struct WrittenMotion {
  std::string bytes;
  std::vector<std::string> losses;  // "joint rotations: TRC has points only"
};

// The coupled joints of a robot; nothing for other bodies.
using Mimics = std::optional<std::vector<MimicJoint>>;

// Writes a motion as a file.
//   BVH, GLB  joints; a marker becomes a joint that only moves, and its gaps are filled: by linear
//             interpolation between the frames beside the gap, at the ends by the nearest frame.
//   TRC, C3D  points: markers, or the positions of the joints.
//   CSV       the table of joints of a robot if `mimics` is set, otherwise a table of points.
//   NPZ       everything.
// Positions differ by at most 0.1 mm after reading back.
//
// INVALID_ARGUMENT if the format is not written (InfoOf), the motion violates CheckWritable, or the
// format cannot express its names, size or frame rate.
absl::StatusOr<WrittenMotion> WriteMotion(FileFormat format, const Motion& motion,
                                          const Mimics& mimics = std::nullopt);

// Whether the format has joints, so that markers lose nothing but gaps in it; false: points.
bool HasJoints(FileFormat format);

// Whether the skeleton is like one of ReadUrdf: one root with six degrees of freedom, and at most
// one at each other joint.
bool IsRobot(const Skeleton& skeleton);

// Returns the positions of all joints as markers with the joints' names.
MarkerMotion JointsAsMarkers(const JointMotion& motion);

}  // namespace motiondb::core
