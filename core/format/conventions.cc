#include "core/format/conventions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/format/text_scanner.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {

namespace {

template <typename T>
void Decide(const ConventionSources<T>& evidence, T& value, Provenance& provenance) {
  if (evidence.given) {
    value = *evidence.given;
    provenance = Provenance::kGiven;
  } else if (evidence.stated) {
    value = *evidence.stated;
    provenance = Provenance::kStated;
  } else if (evidence.deduced) {
    value = *evidence.deduced;
    provenance = Provenance::kDeduced;
  } else {
    value = evidence.fallback;
    provenance = Provenance::kAssumed;
  }
}

}  // namespace

void DecideUnit(const ConventionSources<double>& metres_per_unit, SourceReport& report) {
  Decide(metres_per_unit, report.metres_per_unit, report.unit_provenance);
}

void DecideUpAxis(const ConventionSources<UpAxis>& up, SourceReport& report) {
  Decide(up, report.up_axis, report.up_provenance);
}

std::optional<double> MetresPerUnitNamed(std::string_view name) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr std::array<Unit, 14> kUnits = {{{"m", 1},
                                            {"meter", 1},
                                            {"meters", 1},
                                            {"metre", 1},
                                            {"metres", 1},
                                            {"cm", 0.01},
                                            {"centimeters", 0.01},
                                            {"centimetres", 0.01},
                                            {"mm", 0.001},
                                            {"millimeters", 0.001},
                                            {"millimetres", 0.001},
                                            {"in", 0.0254},
                                            {"inch", 0.0254},
                                            {"inches", 0.0254}}};
  for (const Unit& unit : kUnits) {
    if (IsKeyword(name, unit.name)) return unit.metres;
  }
  return std::nullopt;
}

Eigen::Matrix3d WorldFromFile(UpAxis up) {
  Eigen::Matrix3d rotation;
  switch (up) {
    case UpAxis::kX:
      rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case UpAxis::kY:
      rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case UpAxis::kZ:
      rotation.setIdentity();
      break;
    case UpAxis::kMinusX:
      rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case UpAxis::kMinusY:
      rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
    case UpAxis::kMinusZ:
      rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
      break;
  }
  return rotation;
}

void ToWorld(const SourceReport& report, FrameMatrix& positions) {
  const Eigen::Matrix3f world_from_file =
      (WorldFromFile(report.up_axis) * report.metres_per_unit).cast<float>();
  // One row for each point.
  Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>> points(
      positions.data(), positions.size() / 3, 3);
  points *= world_from_file.transpose();
}

bool IsFrameRate(double rate_hz) { return rate_hz >= 1e-3 && rate_hz <= 1e5; }

double SnapFrameRate(double rate_hz, std::vector<std::string>& notes) {
  constexpr double kClose = 1e-3;
  constexpr double kMinNotedDifference = 1e-6;
  constexpr std::array<double, 4> kBroadcast = {24000.0 / 1001, 30000.0 / 1001, 60000.0 / 1001,
                                                120000.0 / 1001};
  double nearest = std::round(rate_hz);
  for (const double rate : kBroadcast) {
    if (std::abs(rate - rate_hz) < std::abs(nearest - rate_hz)) nearest = rate;
  }
  const double difference = std::abs(nearest - rate_hz) / rate_hz;
  if (nearest <= 0 || difference > kClose) return rate_hz;
  if (difference > kMinNotedDifference) {
    notes.push_back(fmt::format("frame rate {:.8g} Hz taken for {:.8g} Hz", rate_hz, nearest));
  }
  return nearest;
}

namespace {

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

double Median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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

}  // namespace

std::optional<UpAxis> DeduceUpAxis(std::span<const std::string> names,
                                   const FrameMatrix& positions) {
  const std::vector<Eigen::Vector3d> vectors = HeadsAboveFeet(names, positions);
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

std::optional<double> StatureOfPoints(std::span<const std::string> names,
                                      const FrameMatrix& positions) {
  std::vector<double> lengths;
  for (const Eigen::Vector3d& v : HeadsAboveFeet(names, positions)) lengths.push_back(v.norm());
  if (lengths.empty()) return std::nullopt;
  return Median(lengths);
}

std::optional<double> DeduceMetresPerUnit(double stature) {
  constexpr double kPerson = 1.7;
  constexpr double kInch = 0.0254;
  constexpr std::array<double, 5> kUnits = {1, 0.01, 0.001, kInch, kInch / 0.45};
  const auto distance = [stature](double unit) {
    return std::abs(std::log(stature * unit / kPerson));
  };
  const double unit = *std::min_element(
      kUnits.begin(), kUnits.end(), [&](double a, double b) { return distance(a) < distance(b); });
  constexpr double kPlausible = 1.7;  // factor in both directions: 1 m to 2.9 m
  if (!(distance(unit) < std::log(kPlausible))) return std::nullopt;
  return unit;
}

}  // namespace motiondb::core
