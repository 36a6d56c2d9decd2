// Reads the skeleton of a robot from URDF.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/motion.h"
#include "core/motion/robot.h"

namespace motiondb::core {

// A joint coupled to another by a gear or a tendon: q = multiplier * q_master + offset. In the
// skeleton it has no degree of freedom and rests at `offset`; in a motion its value follows from
// its master's. Names are those of the URDF's joints.
struct MimicJoint {
  std::string joint;
  std::string master;  // has one degree of freedom, not a mimic itself
  double multiplier = 1;
  double offset = 0;  // rad or m
};

struct UrdfRobot {
  Skeleton skeleton;
  std::vector<MimicJoint> mimics;  // in the skeleton's order
  RobotDynamics dynamics;
  std::vector<LinkVisual> visuals;  // in the skeleton's order; see ReadLinkVisuals
  SourceReport report;              // metres and z up, by the format; notes on decisions
};

// Reads a robot's kinematics, and its limits of speed and effort, its masses and its visual shapes
// as far as they are given. A speed or an effort of 0 counts as not given. A link with an invalid
// shape has none; the report has a note.
//
// Joint 0 is the floating base. It is named after the root link and has six degrees of freedom:
// translations along the world's x, y and z, then rotations about z, y and x (yaw, pitch, roll).
// The other joints keep their URDF names, in depth-first order, children in file order; a joint's
// frame is its child link's. Revolute and prismatic joints have their limits; continuous joints
// have none. A planar joint has two translations perpendicular to its axis and a rotation about it;
// a floating joint has the same degrees of freedom as the base. A root link whose only joint is
// floating is the world: it is omitted, and that joint is the base, named after its child link.
//
// The file may be compressed with gzip. INVALID_ARGUMENT names file, line and the expected content,
// also if links and joints do not form one tree. O(file size).
absl::StatusOr<UrdfRobot> ReadUrdf(SourceFile file);

}  // namespace motiondb::core
