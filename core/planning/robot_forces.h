// Efforts that a robot's motion needs, and its balance. They are reported; no plan is changed.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/kinematics/inverse_dynamics.h"
#include "core/planning/body.h"

namespace motiondb::core {

// The largest effort of one degree of freedom.
struct PeakEffort {
  int coordinate = 0;  // of the skeleton
  double effort = 0;   // absolute, N m or N
  double seconds = 0;
};

// Distance (m) of the zero-moment point from the edge of the support polygon, positive inside. The
// zero-moment point of a still body is the projection of its centre of mass.
struct Balance {
  double smallest_margin_m = 0;
  double seconds = 0;            // of the smallest margin
  double outside_seconds = 0;    // duration with a negative margin
  double supported_seconds = 0;  // duration with a foot on the floor, in which it is measured
};

struct RobotForces {
  std::vector<PeakEffort> efforts;  // of all coordinates but the root's
  std::optional<Balance> balance;   // absent if no foot stands
};

// A foot on the floor in one frame.
struct StandingFoot {
  int joint = 0;                                     // that the foot moves with
  std::vector<Eigen::Vector2d> places;               // m, of the contact markers on the floor
  Eigen::Vector2d across = Eigen::Vector2d::Zero();  // half of the sole's width, to the left
};

// Returns the point on the floor about which a wrench has no horizontal moment. Nothing if it does
// not press on the floor.
std::optional<Eigen::Vector2d> ZeroMomentPoint(const Wrench& on_robot);

// Returns the distance of a point from the edge of the convex hull of the soles, positive inside.
// Each contact marker is in the middle of a line across its sole. REQUIRES: at least one foot.
double SupportMargin(const std::vector<StandingFoot>& feet, const Eigen::Vector2d& point);

// Divides the wrench of the floor between the standing feet: each carries a share of the force that
// changes linearly from one foot's middle to the other's with the zero-moment point, at its middle
// plus the same offset, so that the sum is the whole wrench. At least one foot.
std::vector<Wrench> ShareWrench(const Wrench& on_robot, const std::vector<StandingFoot>& feet);

// Computes efforts and balance of a motion. `markers` and `contacts`: of its frames; the floor is z
// = 0. Accelerations are means over 0.08 s before and after a frame: recorded motion has noise
// above about 6 Hz, as in gait analysis. These parts at both ends are left out. A foot stands on
// its contacts and on contact markers below 0.02 leg lengths. Its sole is as long as its contact
// markers are apart; URDF files describe its width only by meshes, so half of it is assumed to be
// 0.18 of the length. O(frames * joints).
RobotForces MeasureForces(const Body& body, const RobotDynamics& dynamics,
                          const JointMotion& joints, const MarkerMotion& markers,
                          const ContactMatrix& contacts);

}  // namespace motiondb::core
