#include "core/planning/robot_forces.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "core/motion/forward_kinematics.h"
#include "core/planning/floor.h"
#include "core/planning/splice.h"

namespace motiondb::core {
namespace {

constexpr double kHalfWidth = 0.18;      // of the sole's length: 3 cm of 17 cm on a Unitree G1
constexpr double kSmoothSeconds = 0.08;  // as a low-pass filter of 5.5 Hz
constexpr double kOnFloor = 0.02;        // leg lengths; a lower contact marker supports the foot
constexpr double kMinPressure_n = 1;     // below, the zero-moment point is not defined

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Returns the corners of the convex hull, counter-clockwise (Andrew's monotone chain); of points on
// a line, the ends.
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = hull.size();
    for (const Eigen::Vector2d& point : points) {
      while (hull.size() >= first + 2 &&
             Cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();  // the other side begins there
    std::reverse(points.begin(), points.end());
  }
  return hull.empty() ? std::vector{points.front()} : hull;
}

Eigen::Vector2d Middle(const StandingFoot& foot) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& place : foot.places) sum += place;
  return sum / static_cast<double>(foot.places.size());
}

// Returns the joint of the last coordinate that moves a marker.
int JointOf(const MarkerKinematics& kinematics, int marker) {
  const Skeleton& skeleton = *kinematics.skeleton();
  const int coordinate = kinematics.Coordinates(marker).back();
  int joint = 0;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    if (!skeleton.joints()[j].dofs.empty() && skeleton.first_dof(j) <= coordinate) joint = j;
  }
  return joint;
}

// Returns the feet on the floor in a frame: contacts of the stored frames, which exclude feet that
// move, and low contact markers.
std::vector<StandingFoot> StandingFeet(const Body& body, const std::vector<int>& joints,
                                       const Eigen::Ref<const Eigen::RowVectorXf>& markers_m,
                                       const ContactMatrix& contacts, Eigen::Index frame) {
  std::vector<StandingFoot> standing;
  Eigen::Index column = 0;
  for (std::size_t f = 0; f < body.feet().size(); ++f) {
    StandingFoot foot{.joint = joints[f], .places = {}};
    Eigen::Vector2d length = Eigen::Vector2d::Zero();
    const std::vector<int>& contact_markers = body.feet()[f].contact_markers;
    const auto at = [&](int marker) -> Eigen::Vector2d {
      return markers_m.segment<2>(3 * marker).transpose().cast<double>();
    };
    for (const int marker : contact_markers) {
      const bool low = markers_m[3 * marker + 2] < kOnFloor * body.leg_length_m();
      if (contacts(frame, column++) || low) foot.places.push_back(at(marker));
      const Eigen::Vector2d apart = at(marker) - at(contact_markers.front());
      if (apart.norm() > length.norm()) length = apart;
    }
    foot.across = kHalfWidth * Eigen::Vector2d(-length.y(), length.x());
    if (!foot.places.empty()) standing.push_back(std::move(foot));
  }
  return standing;
}

}  // namespace

std::optional<Eigen::Vector2d> ZeroMomentPoint(const Wrench& on_robot) {
  const double pressure = on_robot.force.z();
  if (!(pressure >= kMinPressure_n)) return std::nullopt;
  return Eigen::Vector2d(-on_robot.moment.y() / pressure, on_robot.moment.x() / pressure);
}

double SupportMargin(const std::vector<StandingFoot>& feet, const Eigen::Vector2d& point) {
  std::vector<Eigen::Vector2d> corners;
  for (const StandingFoot& foot : feet) {
    for (const Eigen::Vector2d& place : foot.places) {
      corners.push_back(place + foot.across);
      corners.push_back(place - foot.across);
    }
  }
  Obstacles support;
  support.polygons.push_back({ConvexHull(std::move(corners))});
  return -Distance(support, point);
}

std::vector<Wrench> ShareWrench(const Wrench& on_robot, const std::vector<StandingFoot>& feet) {
  const auto zero_moment = ZeroMomentPoint(on_robot);
  std::vector<double> shares(feet.size(), 1.0 / static_cast<double>(feet.size()));
  if (zero_moment && feet.size() == 2) {
    const Eigen::Vector2d from = Middle(feet[0]);
    const Eigen::Vector2d apart = Middle(feet[1]) - from;
    const double along = apart.dot(*zero_moment - from) / std::max(1e-9, apart.squaredNorm());
    shares[1] = std::clamp(along, 0.0, 1.0);
    shares[0] = 1 - shares[1];
  }
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  if (zero_moment) {
    offset = *zero_moment;
    for (std::size_t f = 0; f < feet.size(); ++f) offset -= shares[f] * Middle(feet[f]);
  }
  std::vector<Wrench> wrenches;
  for (std::size_t f = 0; f < feet.size(); ++f) {
    Wrench wrench{shares[f] * on_robot.force, shares[f] * on_robot.moment};
    if (zero_moment) {
      const auto on_floor = [](const Eigen::Vector2d& place) {
        return Eigen::Vector3d(place.x(), place.y(), 0);
      };
      // The moment about the zero-moment point is vertical.
      wrench.moment += on_floor(Middle(feet[f]) + offset - *zero_moment).cross(wrench.force);
    }
    wrenches.push_back(wrench);
  }
  return wrenches;
}

RobotForces MeasureForces(const Body& body, const RobotDynamics& dynamics,
                          const JointMotion& joints, const MarkerMotion& markers,
                          const ContactMatrix& contacts) {
  const Skeleton& skeleton = *joints.skeleton;
  const double rate_hz = joints.frame_rate_hz;
  RobotForces forces;
  for (auto c = static_cast<int>(skeleton.joints()[0].dofs.size()); c < skeleton.dof_count(); ++c) {
    forces.efforts.push_back({.coordinate = c});
  }
  std::vector<int> foot_joints;
  for (const Foot& foot : body.feet()) {
    foot_joints.push_back(JointOf(*body.kinematics(), foot.contact_markers.front()));
  }
  const Eigen::Index reach = FramesOf(kSmoothSeconds, rate_hz);
  std::deque<JointPoses> window;  // frames t - reach to t + reach
  for (Eigen::Index next = 0; next < joints.angles.rows(); ++next) {
    window.push_back(ForwardKinematics(skeleton, joints.angles.row(next)));
    if (next < 2 * reach) continue;
    if (next > 2 * reach) window.pop_front();
    const Eigen::Index t = next - reach;
    const JointPoses& at = window[static_cast<std::size_t>(reach)];
    const double seconds = static_cast<double>(t) / rate_hz;
    std::vector<Wrench> wrenches = LinkWrenches(dynamics.links, window.front(), at, window.back(),
                                                rate_hz / static_cast<double>(reach));
    const std::vector<StandingFoot> standing =
        StandingFeet(body, foot_joints, markers.positions_m.row(t), contacts, t);
    if (!standing.empty()) {
      Wrench floor;
      for (const Wrench& wrench : wrenches) floor += wrench;
      const std::vector<Wrench> shares = ShareWrench(floor, standing);
      for (std::size_t f = 0; f < standing.size(); ++f) wrenches[standing[f].joint] -= shares[f];
      if (const auto zero_moment = ZeroMomentPoint(floor)) {
        const double margin = SupportMargin(standing, *zero_moment);
        if (!forces.balance || margin < forces.balance->smallest_margin_m) {
          if (!forces.balance) forces.balance.emplace();
          forces.balance->smallest_margin_m = margin;
          forces.balance->seconds = seconds;
        }
        forces.balance->supported_seconds += 1 / rate_hz;
        if (margin < 0) forces.balance->outside_seconds += 1 / rate_hz;
      }
    }
    const Eigen::RowVectorXd efforts =
        JointEfforts(skeleton, joints.angles.row(t), at, std::move(wrenches));
    for (PeakEffort& peak : forces.efforts) {
      const double effort = std::abs(efforts[peak.coordinate]);
      if (effort > peak.effort) {
        peak.effort = effort;
        peak.seconds = seconds;
      }
    }
  }
  return forces;
}

}  // namespace motiondb::core
