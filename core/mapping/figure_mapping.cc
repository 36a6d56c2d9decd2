#include "core/mapping/figure_mapping.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/mapping/point_sum.h"
#include "core/motion/corrections.h"
#include "core/motion/error.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

PointSum Point(const RolePoint& point) {
  return point.is_found() ? PointSum{{point.index, 1}} : PointSum{};
}

// Proportions of the figures that the standard set was made for, in leg lengths (hip to knee to
// ankle): the means of ten Acclaim skeletons of the CMU and HDM05 collections. Other skeletons of
// the same persons differ by up to 0.12, because their joints are elsewhere.
constexpr double kTrunk = 0.6;        // middle of the hips to middle of the shoulders
constexpr double kMinTrunk = 0.55;    // shorter: arms are raised to kTrunk
constexpr double kBreadth = 0.46;     // between the shoulders
constexpr double kMinBreadth = 0.36;  // narrower: shoulders are moved outwards
constexpr double kMaxWidening = 1.75;
constexpr double kElbowShare = 0.75;  // of the shoulders' movement
constexpr double kForearm = 0.32;
constexpr double kMinForearm = 0.3;     // shorter: the wrist is moved outwards
constexpr double kNeckBelow = 0.05;     // base of the neck below the middle of the shoulders
constexpr double kSkull = 0.22;         // base of the skull above the base of the neck
constexpr double kMiddleOfHead = 0.33;  // above the base of the neck
// Shares of the way from the hips to the base of the neck.
constexpr double kWaistShare = 0.46;
constexpr double kSpineShare = 0.73;
constexpr double kHandShare = 0.25;  // beyond the wrist, in forearm lengths
constexpr double kBallShare = 0.72;  // of the way from the ankle to the tip of the toes

// Returns the necessary roles below the minimum confidence: "left knee ('Calf', 0.31), ...".
std::string UncertainRoles(const Figure& figure) {
  std::string text;
  for (const Role role : kNecessaryRoles) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const RolePoint& point = figure.at(role, side);
      if (point.confidence >= kMinRoleConfidence) continue;
      const std::string found =
          point.is_found()
              ? fmt::format("('{}', {:.2f})", figure.names[point.index], point.confidence)
              : "(none)";
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", RoleName(role, side), found);
    }
  }
  return text;
}

std::string Letter(Side side) { return side == Side::kLeft ? "L" : "R"; }

// The markers of the standard set as sums of the figure's points.
class FigureMarkers {
 public:
  FigureMarkers(const Figure& figure, const PointCloud& points) : figure_(figure), points_(points) {
    const auto left = [&](Role role) { return Point(figure_.at(role, Side::kLeft)); };
    leg_ = Distance(left(Role::kHip), left(Role::kKnee)) +
           Distance(left(Role::kKnee), left(Role::kAnkle));
    const PointSum hips = Middle(Role::kHip);
    trunk_ = Distance(hips, Middle(Role::kShoulder)) / leg_;
    line_.push_back(hips);
    for (const int joint : figure_.spine) line_.push_back({{joint, 1}});
    for (const PointSum& point : {Neck(), Head(), Point(figure_.at(Role::kHeadTop))}) {
      if (!point.empty() && point != line_.back()) line_.push_back(point);
    }
    line_at_.push_back(0);
    for (std::size_t i = 1; i < line_.size(); ++i) {
      line_at_.push_back(line_at_.back() + Distance(line_[i - 1], line_[i]) / leg_);
    }
  }

  // False if no frame has the points of the legs and the trunk.
  bool has_size() const { return leg_ > 0 && trunk_ > 0; }

  std::map<std::string, PointSum> All() const {
    std::map<std::string, PointSum> markers;
    const double neck_at = (trunk_ < kMinTrunk ? kTrunk : trunk_) - kNeckBelow;
    const PointSum neck = AlongLine(neck_at);
    markers["Pelvis"] = line_.front();
    markers["Waist"] = AlongLine(kWaistShare * neck_at);
    markers["Spine"] = AlongLine(kSpineShare * neck_at);
    markers["Neck"] = neck;
    markers["Head"] = AlongLine(neck_at + kSkull);
    markers["HeadTop"] = AlongLine(neck_at + kMiddleOfHead);
    for (const Side side : {Side::kLeft, Side::kRight}) {
      AddLeg(side, markers);
      AddArm(side, neck, markers["Waist"], markers);
    }
    return markers;
  }

 private:
  void AddLeg(Side side, std::map<std::string, PointSum>& markers) const {
    const std::string s = Letter(side);
    const auto at = [&](Role role) { return Point(figure_.at(role, side)); };
    const PointSum hip = at(Role::kHip);
    const PointSum knee = at(Role::kKnee);
    const PointSum ankle = at(Role::kAnkle);
    const PointSum heel = at(Role::kHeel);
    const PointSum toe =
        at(Role::kToe).empty() ? Between(ankle, at(Role::kToeTip), kBallShare) : at(Role::kToe);
    markers[s + "Hip"] = hip;
    markers[s + "Knee"] = knee;
    markers[s + "Ankle"] = ankle;
    markers[s + "Toe"] = toe;
    // Without a heel as in the standard set's default rules.
    markers[s + "Heel"] = heel.empty() ? Total({{1.37, ankle}, {-0.12, knee}, {-0.25, toe}}) : heel;
    markers[s + "Thigh"] = Between(hip, knee, 0.5);
    markers[s + "Shin"] = Between(knee, ankle, 0.5);
  }

  void AddArm(Side side, const PointSum& neck, const PointSum& waist,
              std::map<std::string, PointSum>& markers) const {
    const std::string s = Letter(side);
    const auto at = [&](Role role, Side of) { return Point(figure_.at(role, of)); };
    const Side other = side == Side::kLeft ? Side::kRight : Side::kLeft;
    const PointSum own = at(Role::kShoulder, side);
    const PointSum opposite = at(Role::kShoulder, other);
    const double breadth = Distance(own, opposite) / leg_;
    const double widening =
        breadth > 0 && breadth < kMinBreadth ? std::min(kMaxWidening, kBreadth / breadth) : 1;
    // Outwards by part of the line between the shoulders, upwards along the trunk.
    const double trunk = Distance(waist, neck) / leg_;
    const double raising = trunk_ < kMinTrunk && trunk > 0 ? (kTrunk - trunk_) / trunk : 0;
    const auto moved = [&](const PointSum& point, double share) {
      const double out = share * (widening - 1) / 2;
      return Total({{1, point}, {out, own}, {-out, opposite}, {raising, neck}, {-raising, waist}});
    };
    const PointSum elbow_joint = at(Role::kElbow, side);
    PointSum wrist_joint = at(Role::kWrist, side);
    const double forearm = Distance(elbow_joint, wrist_joint) / leg_;
    const double lengthening = forearm > 0 && forearm < kMinForearm ? kForearm / forearm : 1;
    const PointSum hand_joint = at(Role::kHand, side);
    const PointSum hand = hand_joint.empty()
                              ? Between(elbow_joint, wrist_joint, lengthening + kHandShare)
                              : Total({{1, Between(wrist_joint, hand_joint, 0.5)},
                                       {lengthening - 1, wrist_joint},
                                       {1 - lengthening, elbow_joint}});
    wrist_joint = Between(elbow_joint, wrist_joint, lengthening);
    const PointSum shoulder = moved(own, 1);
    const PointSum elbow = moved(elbow_joint, kElbowShare);
    const PointSum wrist = moved(wrist_joint, kElbowShare);
    markers[s + "Clavicle"] = Between(neck, shoulder, 0.5);
    markers[s + "Shoulder"] = shoulder;
    markers[s + "UpperArm"] = Between(shoulder, elbow, 0.5);
    markers[s + "Elbow"] = elbow;
    markers[s + "Forearm"] = Between(elbow, wrist, 0.5);
    markers[s + "Wrist"] = wrist;
    markers[s + "Hand"] = moved(hand, kElbowShare);
  }

  PointSum Middle(Role role) const {
    return Between(Point(figure_.at(role, Side::kLeft)), Point(figure_.at(role, Side::kRight)),
                   0.5);
  }

  PointSum Neck() const {
    const PointSum neck = Point(figure_.at(Role::kNeck));
    return neck.empty() ? Middle(Role::kShoulder) : neck;
  }

  PointSum Head() const {
    if (figure_.at(Role::kHead).is_found()) return Point(figure_.at(Role::kHead));
    if (const PointSum ears = Middle(Role::kEar); !ears.empty()) return ears;
    if (const PointSum eyes = Middle(Role::kEye); !eyes.empty()) return eyes;
    return Point(figure_.at(Role::kNose));
  }

  // Median distance over the frames.
  double Distance(const PointSum& a, const PointSum& b) const {
    std::vector<double> distances;
    for (const auto& frame : points_.frames) {
      Eigen::Vector3d difference = Eigen::Vector3d::Zero();
      for (const auto& [point, weight] : b) difference += weight * frame.col(point);
      for (const auto& [point, weight] : a) difference -= weight * frame.col(point);
      if (difference.allFinite()) distances.push_back(difference.norm());
    }
    return distances.empty() ? 0 : Median(distances);
  }

  // Returns the point at this distance (leg lengths) from the hips along spine, neck and head; on
  // the last segment extended beyond its end.
  PointSum AlongLine(double distance) const {
    std::size_t end = 1;
    while (end + 1 < line_at_.size() && line_at_[end] < distance) ++end;
    // A short last segment has no reliable direction.
    const bool is_beyond = line_at_[end] < distance;
    if (is_beyond && end > 1 && line_at_[end] - line_at_[end - 1] < 0.05) --end;
    const double length = line_at_[end] - line_at_[end - 1];
    return Between(line_[end - 1], line_[end],
                   length > 0 ? (distance - line_at_[end - 1]) / length : 0);
  }

  const Figure& figure_;
  const PointCloud& points_;
  double leg_ = 1;
  double trunk_ = 0;             // leg lengths
  std::vector<PointSum> line_;   // hips, spine, neck, head
  std::vector<double> line_at_;  // leg lengths from the hips along the line
};

// Returns the mean, over the frames, of a vector in the frame of a joint; the vector is given by
// its components in front of the body and upwards along the trunk.
Eigen::Vector3d InJoint(const Figure& figure, const PointCloud& points, int joint, double forward,
                        double up) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t f = 0; f < points.frames.size(); ++f) {
    const auto at = [&](Role role, Side side) -> Eigen::Vector3d {
      return points.frames[f].col(figure.at(role, side).index);
    };
    const Eigen::Vector3d lateral = at(Role::kHip, Side::kLeft) - at(Role::kHip, Side::kRight);
    const Eigen::Vector3d trunk = at(Role::kShoulder, Side::kLeft) +
                                  at(Role::kShoulder, Side::kRight) - at(Role::kHip, Side::kLeft) -
                                  at(Role::kHip, Side::kRight);
    const Eigen::Vector3d front = lateral.cross(trunk).normalized();
    const Eigen::Vector3d vector = forward * front + up * trunk.normalized();
    if (vector.allFinite()) sum += points.rotations[f][joint].transpose() * vector;
  }
  const double length = std::hypot(forward, up);
  return sum.norm() > 0 ? Eigen::Vector3d(length * sum.normalized()) : sum;
}

constexpr const char* kRoleNames[] = {"pelvis", "spine",   "neck",     "head",     "head top",
                                      "nose",   "hip",     "knee",     "ankle",    "heel",
                                      "toe",    "toe tip", "clavicle", "shoulder", "elbow",
                                      "wrist",  "hand",    "eye",      "ear"};
static_assert(std::size(kRoleNames) == kRoleCount);

}  // namespace

std::string RoleName(Role role, Side side) {
  const std::string name = kRoleNames[static_cast<std::size_t>(role)];
  if (role < Role::kHip) return name;
  return (side == Side::kRight ? "right " : "left ") + name;
}

std::vector<std::string> DerivedMarkersOf(const Figure& figure, bool has_hierarchy) {
  std::vector<std::string> derived;
  const auto add_if = [&](bool is_derived, std::initializer_list<const char*> markers) {
    if (is_derived) derived.insert(derived.end(), markers.begin(), markers.end());
  };
  const auto has = [&](Role role, Side side = Side::kNone) {
    return figure.at(role, side).is_found();
  };
  const bool has_spine = !figure.spine.empty();
  add_if(!has_spine, {"Waist", "Spine"});
  add_if(!has_spine && !has(Role::kNeck), {"Neck", "LClavicle", "RClavicle"});
  add_if(!has(Role::kHead) && !has(Role::kHeadTop) &&
             !(has(Role::kEar, Side::kLeft) && has(Role::kEar, Side::kRight)),
         {"Head", "HeadTop"});
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const bool left = side == Side::kLeft;
    const bool has_toes = has(Role::kToe, side) || has(Role::kToeTip, side);
    add_if(!has_toes, {left ? "LToe" : "RToe"});
    add_if(!has_toes && !has(Role::kHeel, side), {left ? "LHeel" : "RHeel"});
    // A skeleton's hand continues its forearm.
    add_if(!has_hierarchy && !has(Role::kHand, side), {left ? "LHand" : "RHand"});
  }
  return derived;
}

absl::StatusOr<MarkerMapping> MapFigure(const MarkerSet& set, const Figure& figure,
                                        const PointCloud& points) {
  if (!figure.problem.empty()) return InvalidArgument("{}", figure.problem);
  if (const std::string uncertain = UncertainRoles(figure); !uncertain.empty()) {
    return InvalidArgument("uncertain: {}; expected a confidence of {:.2f}", uncertain,
                           kMinRoleConfidence);
  }
  const FigureMarkers body(figure, points);
  if (!body.has_size()) return InvalidArgument("no frame has both legs and both shoulders");
  const std::map<std::string, PointSum> markers = body.All();
  MarkerMapping mapping = MappingFrom(set, markers, figure.names);
  // Feet without toes have no direction but that of the body.
  if (points.rotations.empty()) return mapping;
  for (const auto& [marker, from, front, up] : DerivedMarkers()) {
    if (from != std::string("LAnkle") && from != std::string("RAnkle")) continue;
    const int at = set.FindMarker(marker);
    if (at < 0 || !mapping.rules[at].points.empty()) continue;
    const int ankle = figure.at(Role::kAnkle, from[0] == 'L' ? Side::kLeft : Side::kRight).index;
    mapping.rules[at] = {
        {{figure.names[ankle], 1}}, figure.names[ankle], InJoint(figure, points, ankle, front, up)};
  }
  return mapping;
}

}  // namespace motiondb::core
