// Writes motion to files for animation tools, robot controllers and programs of motion capture.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

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

// Returns the names that WriteBvh gives to the skeleton's joints, in their order. O(joints).
std::vector<std::string> BvhNames(const Skeleton& skeleton);

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

// Returns the motion as GLB (glTF 2.0 in one binary file) in metres, y up, with one animation.
//
// Every joint is a node in its parent's frame, at rest with all degrees of freedom zero. Roots are
// converted to y up; several roots get a common parent. Joints with rotations have rotation keys;
// roots and joints with translations have translation keys. Frame i is at i / rate seconds, with
// linear interpolation. Numbers are single precision, and consecutive quaternions have the nearer
// sign. `asset.extras.frame_rate_hz` is the frame rate, because keys alone do not tell it for one
// frame or below 10 Hz. A skin and a mesh with an octahedron for each bone make the figure visible.
// Names are made valid UTF-8 of at most 255 bytes, unique. O(frames * joints).
//
// INVALID_ARGUMENT as for CheckWritable, if there are more than
// kMaxFileJoints joints, if a joint is more than 1e18 m from its parent, if single precision cannot
// distinguish the times of two frames, or if the file would exceed 4 GiB.
absl::StatusOr<std::string> WriteGlb(const JointMotion& motion);

// Returns the names that WriteGlb gives to the skeleton's joints, in their order. O(joints).
std::vector<std::string> GlbNames(const Skeleton& skeleton);

// Returns the motion as a TRC file of OpenSim: millimetres with 9 digits, y up, tabs. The cells of
// a missing point are empty. The format does not state the up axis: OpenSim expects y, and ReadTrc
// deduces it from heads and feet, or assumes y; pass the option for a person who lies all the time.
// O(frames * points).
//
// INVALID_ARGUMENT as for WritablePointNames, or for more than 65,535 points.
absl::StatusOr<std::string> WriteTrc(const MarkerMotion& motion);

// Returns the motion as CSV (RFC 4180, but with LF line ends): a header with time_s, then NAME_x_m,
// NAME_y_m, NAME_z_m of each point, in the world, z up; then a line for each frame, from 0 s. The
// cells of a missing point are empty. Numbers are the shortest that read back to the same value.
// O(frames * points).
//
// INVALID_ARGUMENT as for WritablePointNames, or for more than 65,535 points.
absl::StatusOr<std::string> WritePointTable(const MarkerMotion& motion);

// Returns the motion as C3D with real numbers in Intel byte order, in millimetres, z up, without
// analog channels. A missing marker has the residual -1. A marker exactly at the origin, which
// readers take for missing, is written 1 nm above it. Frames are numbered from 1; more than 65535
// are counted in TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD. Labels are the names for a text
// file (WritablePointNames), cut to 255 bytes. O(frames * markers).
//
// After reading back, positions within 4 m of the origin differ by less than a micrometre.
//
// INVALID_ARGUMENT as for WritablePointNames, for more than 65535
// markers or 2^31 - 1 frames, for two labels that are equal after cutting, and if the labels do not
// fit the 130,560 bytes of the parameters.
absl::StatusOr<std::string> WriteC3d(const MarkerMotion& motion);

// Returns the labels that WriteC3d gives to the markers, or its error about them. O(frames *
// markers).
absl::StatusOr<std::vector<std::string>> C3dLabels(const MarkerMotion& motion);

inline constexpr int kNpzVersion = 1;  // `motiondb_version` of a written archive

// Returns the motion as an uncompressed .npz archive. Metres, z up; numbers are little-endian
// float64, indices int32, names UTF-32 ("<U"); arrays are in C order. N: joints or markers.
//
//   motiondb_version  ()              1
//   frame_rate_hz     ()
//   joints:
//     joint_names       (N)
//     parents           (N)             index of the parent, which precedes the joint; -1: a root
//     offsets_m         (N, 3)          rest position in the parent's frame, of a root in the world
//     rest_rotations    (N, 4)          orientation at zero angles, as `local_rotations`
//     local_rotations   (frames, N, 4)  unit quaternions x y z w: parent_from_joint, for a root
//                                       world_from_joint. The first of a joint has w >= 0, the
//                                       others the sign nearer to the previous one.
//     local_positions_m (frames, N, 3)  as `offsets_m`, with translations
//     positions_m       (frames, N, 3)  of the joints in the world, which follow from the above
//   markers:
//     marker_names      (N)
//     positions_m       (frames, N, 3)  in the world; NaN: missing
//
// The archive keeps the motion of all joints, but not their axes of rotation and limits. Bytes
// depend only on the motion: members have the date 1980-01-01. O(frames * N).
//
// INVALID_ARGUMENT as for CheckWritable, if a joint's frame is not a rotation, if a name appears
// twice, or if the archive would exceed 4 GiB, the limit of zip without extensions.
absl::StatusOr<std::string> WriteNpz(const Motion& motion);

// INVALID_ARGUMENT, beginning with `format`, if the motion has no skeleton, no frame, a frame rate
// out of 0.001 to 100000 Hz, columns other than the skeleton's degrees of freedom, or a number that
// is not finite.
absl::Status CheckWritable(std::string_view format, const JointMotion& motion);

// Returns the names for a text file: valid UTF-8, without blanks at the ends, and with '_' for each
// tab, line end or other control character. INVALID_ARGUMENT, beginning with `format`, as for
// CheckWritable, for an empty name and for two points with the same name.
absl::StatusOr<std::vector<std::string>> WritablePointNames(std::string_view format,
                                                            const MarkerMotion& motion);

// INVALID_ARGUMENT, beginning with `format`, if the motion has no point, no frame, a frame rate out
// of 0.001 to 100000 Hz, columns other than three a point, a point with one or two missing
// coordinates, or a coordinate that is infinite or beyond 1e12 m.
absl::Status CheckWritable(std::string_view format, const MarkerMotion& motion);

}  // namespace motiondb::core
