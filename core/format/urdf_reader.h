// URDF -> the skeleton of a robot. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/motion/skeleton.h"

namespace motiondb::core {

// A joint that follows another by a gear or a tendon: q = multiplier * q_master + offset. In the
// skeleton it has no degree of freedom and rests at `offset`; its value in a motion follows from
// its master's. Names are the URDF's joints.
struct MimicJoint {
  std::string joint;
  std::string master;  // has one degree of freedom and follows no other
  double multiplier = 1;
  double offset = 0;  // rad or m
};

struct UrdfRobot {
  Skeleton skeleton;
  std::vector<MimicJoint> mimics;  // in the skeleton's order
  SourceReport report;             // metres and z up, as URDF has them; notes on what was decided
};

// Reads a robot's kinematics.
//
// Joint 0 is the floating base. It is named after the root link and has six degrees of freedom:
// translations along the world's x, y and z, then rotations about z, y and x (yaw, pitch, roll).
// Every other joint has its URDF name, in depth-first order, children as the file lists them; its
// frame is its child link's. Revolute and prismatic joints have their limits; a continuous one has
// none. A planar joint has two translations at right angles to its axis and a rotation about it; a
// floating one has those of the base. A root link that carries one floating joint and nothing else
// is the world: it is left out, and that joint is the base, named after its child link.
//
// INVALID_ARGUMENT names file, line and what was expected, also where links and joints are not one
// tree. O(file).
absl::StatusOr<UrdfRobot> ReadUrdf(SourceFile file);

}  // namespace motiondb::core
