#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/format/conventions.h"
#include "core/mapping/figure.h"
#include "core/motion/marker_set.h"
#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kPerson_m = 1.7;  // stature
constexpr int kSampledFrames = 31;

bool ContainsAny(std::string_view name, std::span<const std::string_view> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](std::string_view part) { return name.find(part) != name.npos; });
}

bool IsHead(std::string_view name) {
  constexpr std::array<std::string_view, 3> kParts = {"head", "fhd", "bhd"};
  return ContainsAny(PlainName(name), kParts);
}

bool IsFoot(std::string_view name) {
  constexpr std::array<std::string_view, 4> kParts = {"foot", "toe", "ankle", "heel"};
  constexpr std::array<std::string_view, 6> kMarkers = {"lank", "rank", "lhee",
                                                        "rhee", "lmt5", "rmt5"};
  const std::string plain = PlainName(name);
  return ContainsAny(plain, kParts) ||
         std::find(kMarkers.begin(), kMarkers.end(), plain) != kMarkers.end();
}

struct HeadsAndFeet {
  std::vector<int> heads;
  std::vector<int> feet;
};

HeadsAndFeet FindHeadsAndFeet(std::span<const std::string> names) {
  HeadsAndFeet found;
  for (int i = 0; i < static_cast<int>(names.size()); ++i) {
    if (IsHead(names[i])) {
      found.heads.push_back(i);
    } else if (IsFoot(names[i])) {
      found.feet.push_back(i);
    }
  }
  return found;
}

// Returns the mean of the points that are present in the frame.
std::optional<Eigen::Vector3d> MeanPoint(const FrameMatrix& positions, Eigen::Index frame,
                                         const std::vector<int>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const int point : points) {
    const Eigen::Vector3d position =
        positions.block<1, 3>(frame, 3 * point).transpose().cast<double>();
    if (!position.allFinite()) continue;
    sum += position;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

// Returns the vectors from the feet to the head in frames spread over the clip.
std::vector<Eigen::Vector3d> HeadsAboveFeet(std::span<const std::string> names,
                                            const FrameMatrix& positions) {
  const HeadsAndFeet points = FindHeadsAndFeet(names);
  std::vector<Eigen::Vector3d> vectors;
  const Eigen::Index step = std::max<Eigen::Index>(1, positions.rows() / kSampledFrames);
  for (Eigen::Index frame = 0; frame < positions.rows(); frame += step) {
    const auto head = MeanPoint(positions, frame, points.heads);
    const auto feet = MeanPoint(positions, frame, points.feet);
    if (head && feet) vectors.push_back(*head - *feet);
  }
  return vectors;
}

// Returns the path length along the bones from each joint to the nearest of `ends`; infinite if its
// tree has none. O(joints) for any names: a file may call every joint a head or a foot.
std::vector<double> DistancesToNearest(const Skeleton& skeleton, const FrameMatrix& positions,
                                       Eigen::Index frame, const std::vector<int>& ends) {
  std::vector<double> distance_to_end(static_cast<std::size_t>(skeleton.joint_count()),
                                      std::numeric_limits<double>::infinity());
  for (const int end : ends) distance_to_end[end] = 0;
  const auto shorten = [&](int joint, int parent, int to, int from) {
    const auto bone =
        positions.block<1, 3>(frame, 3 * joint) - positions.block<1, 3>(frame, 3 * parent);
    distance_to_end[to] =
        std::min(distance_to_end[to], distance_to_end[from] + bone.cast<double>().norm());
  };
  // First from children to parents (parents precede children), then back.
  for (int joint = skeleton.joint_count() - 1; joint >= 0; --joint) {
    const int parent = skeleton.joints()[joint].parent;
    if (parent >= 0) shorten(joint, parent, parent, joint);
  }
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    const int parent = skeleton.joints()[joint].parent;
    if (parent >= 0) shorten(joint, parent, joint, parent);
  }
  return distance_to_end;
}

// Returns the axis along which most vectors from feet to head point; nothing if no axis dominates.
std::optional<UpAxis> UpAxisOf(const std::vector<Eigen::Vector3d>& vectors) {
  if (vectors.empty()) return std::nullopt;
  Eigen::Vector3d median;
  std::vector<double> values(vectors.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(vectors.begin(), vectors.end(), values.begin(),
                   [axis](const Eigen::Vector3d& v) { return v[axis]; });
    median[axis] = Median(values);
  }
  int up = 0;
  median.cwiseAbs().maxCoeff(&up);
  constexpr double kDominance = 1.5;
  for (int axis = 0; axis < 3; ++axis) {
    if (axis != up && std::abs(median[up]) <= kDominance * std::abs(median[axis])) {
      return std::nullopt;
    }
  }
  constexpr std::array<UpAxis, 3> kPlus = {UpAxis::kX, UpAxis::kY, UpAxis::kZ};
  constexpr std::array<UpAxis, 3> kMinus = {UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};
  return median[up] > 0 ? kPlus[up] : kMinus[up];
}

// Returns the path length along the bones from a foot to the head, independent of the pose.
std::optional<double> StatureAlongBones(const Skeleton& skeleton, const FrameMatrix& positions) {
  std::vector<std::string> names;
  for (const Joint& joint : skeleton.joints()) names.push_back(joint.name);
  const HeadsAndFeet joints = FindHeadsAndFeet(names);
  // Use the last joint of the head and the first of the foot: an ankle, not a toe.
  const std::vector<double> distance_to_end =
      DistancesToNearest(skeleton, positions, 0, joints.feet);
  double stature = 0;
  for (const int head : joints.heads) {
    if (std::isfinite(distance_to_end[head])) stature = std::max(stature, distance_to_end[head]);
  }
  if (stature <= 0) return std::nullopt;
  return stature;
}

// Returns the median distance between head and feet.
std::optional<double> MedianLength(const std::vector<Eigen::Vector3d>& vectors) {
  std::vector<double> lengths;
  lengths.reserve(vectors.size());
  for (const Eigen::Vector3d& v : vectors) lengths.push_back(v.norm());
  if (lengths.empty()) return std::nullopt;
  return Median(lengths);
}

// Returns the unit for which the stature is closest to a person's. Nothing if none is plausible.
std::optional<double> MetresPerUnitOf(double stature) {
  constexpr double kInch = 0.0254;
  constexpr std::array<double, 5> kUnits = {1, 0.01, 0.001, kInch, kInch / 0.45};
  const auto distance = [stature](double unit) {
    return std::abs(std::log(stature * unit / kPerson_m));
  };
  const double unit = *std::min_element(
      kUnits.begin(), kUnits.end(), [&](double a, double b) { return distance(a) < distance(b); });
  constexpr double kPlausible = 1.7;  // factor in both directions: 1 m to 2.9 m
  if (!(distance(unit) < std::log(kPlausible))) return std::nullopt;
  return unit;
}

// Estimates without names that tell heads and feet: from the figure of a person.
struct FigureSize {
  std::optional<double> stature;
  std::vector<Eigen::Vector3d> above_feet;  // from the ankles to the shoulders, in each frame
};

FigureSize MeasureFigure(std::span<const std::string> names, const FrameMatrix& positions,
                         const Skeleton* skeleton) {
  constexpr double kLegOfStature = 0.491;  // hip to ankle: Winter, after Drillis and Contini
  PointCloud points;
  points.names.assign(names.begin(), names.end());
  if (skeleton != nullptr) {
    for (const Joint& joint : skeleton->joints()) points.parents.push_back(joint.parent);
  }
  const Eigen::Index step = std::max<Eigen::Index>(1, positions.rows() / kSampledFrames);
  for (Eigen::Index frame = 0; frame < positions.rows(); frame += step) {
    const Eigen::RowVectorXd row = positions.row(frame).cast<double>();
    points.frames.emplace_back(
        Eigen::Map<const Eigen::Matrix3Xd>(row.data(), 3, std::ssize(names)));
  }
  FigureSize size;
  const Figure figure = FindFigure(points);
  if (!figure.problem.empty()) return size;
  std::vector<double> legs;
  for (const Eigen::Matrix3Xd& frame : points.frames) {
    const auto at = [&](Role role, Side side) -> Eigen::Vector3d {
      return frame.col(figure.at(role, side).index);
    };
    Eigen::Vector3d above = Eigen::Vector3d::Zero();
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const Eigen::Vector3d knee = at(Role::kKnee, side);
      const double leg =
          (at(Role::kHip, side) - knee).norm() + (knee - at(Role::kAnkle, side)).norm();
      if (std::isfinite(leg)) legs.push_back(leg);
      above += at(Role::kShoulder, side) - at(Role::kAnkle, side);
    }
    if (above.allFinite()) size.above_feet.push_back(above);
  }
  if (!legs.empty()) size.stature = Median(legs) / kLegOfStature;
  return size;
}

// Whether all joints are children of a root, so that they are points without bones. End sites do
// not count.
bool HasNoBones(const Skeleton& skeleton) {
  constexpr std::size_t kFewJoints = 4;
  const std::vector<Joint>& joints = skeleton.joints();
  return joints.size() > kFewJoints && std::ranges::all_of(joints, [&](const Joint& joint) {
           return joint.parent < 0 || joint.dofs.empty() || joints[joint.parent].parent < 0;
         });
}

}  // namespace

DeducedConventions DeduceConventions(std::span<const std::string> names,
                                     const FrameMatrix& positions, const Skeleton* skeleton) {
  if (skeleton != nullptr && HasNoBones(*skeleton)) skeleton = nullptr;
  std::vector<Eigen::Vector3d> above_feet = HeadsAboveFeet(names, positions);
  DeducedConventions deduced;
  deduced.stature =
      skeleton == nullptr ? MedianLength(above_feet) : StatureAlongBones(*skeleton, positions);
  if (!deduced.stature || above_feet.empty()) {
    FigureSize size = MeasureFigure(names, positions, skeleton);
    if (!deduced.stature) deduced.stature = size.stature;
    if (above_feet.empty()) above_feet = std::move(size.above_feet);
  }
  if (deduced.stature && !(*deduced.stature > 0)) deduced.stature.reset();
  if (deduced.stature) deduced.metres_per_unit = MetresPerUnitOf(*deduced.stature);
  deduced.up_axis = UpAxisOf(above_feet);
  return deduced;
}

void DecideUnit(std::optional<double> given, std::optional<double> stated,
                const DeducedConventions& deduced, double usual, SourceReport& report) {
  const double fallback = deduced.stature ? kPerson_m / *deduced.stature : usual;
  DecideUnit({given, stated, deduced.metres_per_unit, fallback}, report);
  if (report.unit_provenance != Provenance::kAssumed) return;
  report.notes.push_back(
      deduced.stature
          ? fmt::format("a stature of {:.4g} units fits no known unit: scaled to a stature of {} m",
                        *deduced.stature, kPerson_m)
          : fmt::format("no figure of a person: {} m per unit assumed", usual));
}

}  // namespace motiondb::core
