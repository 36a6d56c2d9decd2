#include "tests/core/mapping/convention_body.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <sstream>

namespace motiondb::tests {
namespace {

using Eigen::Vector3d;

// A site beside a point: the point (a site of the same side), and the displacement in leg lengths
// to the front, upwards and outwards.
struct Beside {
  const char* from;
  double front, up, out;
};

const std::map<std::string, Beside>& SidedSites() {
  static const std::map<std::string, Beside> sites = {{"eye", {"head", 0.1, 0.1, 0.04}},
                                                      {"ear", {"head", 0, 0.09, 0.09}},
                                                      {"head_front", {"head", 0.1, 0.16, 0.07}},
                                                      {"head_back", {"head", -0.1, 0.16, 0.07}},
                                                      {"head_side", {"head", 0, 0.12, 0.1}},
                                                      {"breast", {"Spine", 0.13, 0, 0.1}},
                                                      {"buttock", {"Pelvis", -0.13, 0, 0.08}},
                                                      {"asis", {"Pelvis", 0.12, 0.1, 0.15}},
                                                      {"psis", {"Pelvis", -0.12, 0.11, 0.05}},
                                                      {"waist_side", {"Waist", 0, 0, 0.15}},
                                                      {"acromion", {"Shoulder", 0, 0.06, 0}},
                                                      {"scapula", {"Shoulder", -0.08, 0, 0}},
                                                      {"shoulder_back", {"Shoulder", -0.08, 0, 0}},
                                                      {"upper_arm_out", {"UpperArm", 0, 0, 0.05}},
                                                      {"elbow_out", {"Elbow", 0, 0, 0.045}},
                                                      {"elbow_in", {"Elbow", 0, 0, -0.045}},
                                                      {"forearm_out", {"Forearm", 0, 0, 0.03}},
                                                      {"wrist_thumb", {"Wrist", 0.035, 0, 0}},
                                                      {"wrist_pinky", {"Wrist", -0.035, 0, 0}},
                                                      {"hand_in", {"hand", 0.04, 0, 0}},
                                                      {"hand_out", {"hand", -0.04, 0, 0}},
                                                      {"finger_base", {"hand", 0, 0, 0}},
                                                      {"thigh_out", {"Thigh", 0, 0, 0.08}},
                                                      {"knee_out", {"Knee", 0, 0, 0.06}},
                                                      {"knee_in", {"Knee", 0, 0, -0.06}},
                                                      {"shin_out", {"Shin", 0, 0, 0.05}},
                                                      {"shin_front", {"Shin", 0.05, 0, 0}},
                                                      {"ankle_out", {"Ankle", 0, 0, 0.04}},
                                                      {"ankle_in", {"Ankle", 0, 0, -0.04}},
                                                      {"toe_big", {"Toe", 0, 0, -0.04}},
                                                      {"toe_small", {"Toe", 0, 0, 0.05}},
                                                      {"hip", {"Hip", 0, 0, 0}},
                                                      {"knee", {"Knee", 0, 0, 0}},
                                                      {"ankle", {"Ankle", 0, 0, 0}},
                                                      {"heel", {"Heel", 0, 0, 0}},
                                                      {"toe", {"Toe", 0, 0, 0}},
                                                      {"shoulder", {"Shoulder", 0, 0, 0}},
                                                      {"elbow", {"Elbow", 0, 0, 0}},
                                                      {"wrist", {"Wrist", 0, 0, 0}}};
  return sites;
}

const std::map<std::string, Beside>& MiddleSites() {
  static const std::map<std::string, Beside> sites = {{"pelvis", {"Pelvis", 0, 0.08, 0}},
                                                      {"neck", {"Neck", 0, 0, 0}},
                                                      {"head", {"Head", 0, 0, 0}},
                                                      {"nose", {"Head", 0.12, 0.08, 0}},
                                                      {"jaw", {"Head", 0.08, 0.02, 0}},
                                                      {"head_front", {"Head", 0.12, 0.16, 0}},
                                                      {"c7", {"Neck", -0.08, 0.05, 0}},
                                                      {"t10", {"Spine", -0.12, 0, 0}},
                                                      {"clav", {"Neck", 0.09, 0, 0}},
                                                      {"strn", {"Spine", 0.13, 0, 0}},
                                                      {"sacrum", {"Pelvis", -0.13, 0.09, 0}},
                                                      {"belly", {"Waist", 0.13, 0, 0}},
                                                      {"waist_front", {"Waist", 0.13, 0, 0}},
                                                      {"waist_back", {"Waist", -0.13, 0, 0}},
                                                      {"rback", {"Spine", -0.12, 0, -0.1}}};
  return sites;
}

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

std::string WithSpaces(std::string name) {
  std::ranges::replace(name, '~', ' ');
  return name;
}

}  // namespace

std::vector<Convention> ReadConventions(std::string_view tables) {
  std::vector<Convention> conventions;
  std::istringstream in{std::string(tables)};
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    const std::vector<std::string> words = SplitAt(line, ' ');
    CAPTURE(line);
    REQUIRE(words.size() >= 2);
    if (words[0] == "convention") {
      conventions.push_back({.name = words[1], .joints = {}, .parents = {}, .sites = {}});
      continue;
    }
    REQUIRE(!conventions.empty());
    Convention& convention = conventions.back();
    if (words[0] == "kind") {
      convention.is_hierarchy = words[1] == "joints";
      continue;
    }
    REQUIRE(words.size() == 3);
    int parent = -1;
    if (words[1] != "-") {
      const auto at = std::ranges::find(convention.joints, WithSpaces(words[1]));
      REQUIRE(at != convention.joints.end());
      parent = static_cast<int>(at - convention.joints.begin());
    }
    convention.joints.push_back(WithSpaces(words[0]));
    convention.parents.push_back(parent);
    convention.sites.push_back(words[2]);
  }
  return conventions;
}

ConventionBody::ConventionBody(const core::MarkerMotion& markers, Eigen::Index frame,
                               double leg_length_m)
    : leg_(leg_length_m) {
  for (std::size_t m = 0; m < markers.names.size(); ++m) {
    markers_[markers.names[m]] = markers.positions_m.row(frame)
                                     .segment<3>(static_cast<Eigen::Index>(3 * m))
                                     .cast<double>()
                                     .transpose();
  }
  left_ = (marker("LHip") - marker("RHip")).normalized();
  up_ = (marker("Spine") - marker("Pelvis")).normalized();
  front_ = left_.cross(up_).normalized();
}

Vector3d ConventionBody::Moved(const Vector3d& from, double front, double up, double left) const {
  return from + leg_ * (front * front_ + up * up_ + left * left_);
}

Vector3d ConventionBody::AlongSpine(double share) const {
  const std::array<Vector3d, 4> way = {marker("Pelvis"), marker("Waist"), marker("Spine"),
                                       marker("Neck")};
  double rest = 0;
  for (std::size_t i = 1; i < way.size(); ++i) rest += share * (way[i] - way[i - 1]).norm();
  for (std::size_t i = 1;; ++i) {
    const double length = (way[i] - way[i - 1]).norm();
    if (rest <= length || i + 1 == way.size()) {
      return way[i - 1] + rest / length * (way[i] - way[i - 1]);
    }
    rest -= length;
  }
}

Vector3d ConventionBody::Finger(const std::string& side, int finger, int segment) const {
  const Vector3d wrist = marker(side + "Wrist");
  const Vector3d along = (wrist - marker(side + "Elbow")).normalized();
  const Vector3d across = along.cross(up_).normalized() * (0.02 * (finger - 3));
  if (finger == 1) return wrist + leg_ * ((0.03 + 0.035 * segment) * along + 2 * across);
  return wrist + leg_ * ((0.07 + 0.04 * segment) * along + across);
}

Vector3d ConventionBody::Between(const std::string& site) const {
  std::vector<std::string> parts = SplitAt(site, ':');
  const double share = std::stod(parts.back());
  parts.erase(parts.begin());
  parts.pop_back();
  std::vector<std::string> ends;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ends.push_back(parts[i]);
    const std::size_t numbers = parts[i] == "spine" ? 1 : parts[i].ends_with("_finger") ? 2 : 0;
    for (std::size_t n = 0; n < numbers && i + 1 < parts.size(); ++n)
      ends.back() += ":" + parts[++i];
  }
  REQUIRE(ends.size() == 2);
  return (1 - share) * Site(ends[0]) + share * Site(ends[1]);
}

Vector3d ConventionBody::Site(const std::string& site) const {
  CAPTURE(site);
  if (site.starts_with("between:")) return Between(site);
  if (site.starts_with("spine:")) return AlongSpine(std::stod(site.substr(6)));
  if (site == "origin") return Vector3d::Zero();
  if (site == "floor") return {marker("Pelvis").x(), marker("Pelvis").y(), 0};
  if (site == "head_top") return marker("Head") + 2 * (marker("HeadTop") - marker("Head"));
  if (const auto at = MiddleSites().find(site); at != MiddleSites().end()) {
    const auto& [from, front, up, left] = at->second;
    return Moved(marker(from), front, up, left);
  }
  const std::string held = site.starts_with("prop:") ? site.substr(5) : site;
  const bool is_left = held.starts_with("l_");
  REQUIRE((is_left || held.starts_with("r_")));
  const std::string side = is_left ? "L" : "R";
  const std::string name = held.substr(2);
  const auto own = [&](const std::string& marker_name) { return marker(side + marker_name); };
  if (name.starts_with("finger:")) return Finger(side, name.at(7) - '0', name.at(9) - '0');
  if (name == "hand") return Finger(side, 3, held == site ? 1 : 9);
  if (name == "toe_tip") return own("Toe") + 0.45 * (own("Toe") - own("Ankle"));
  if (name == "clavicle") return 0.85 * marker("Neck") + 0.15 * own("Shoulder");
  const auto at = SidedSites().find(name);
  REQUIRE(at != SidedSites().end());
  const auto& [from, front, up, out] = at->second;
  const std::string point = from;
  const bool is_middle = point == "Pelvis" || point == "Waist" || point == "Spine";
  const Vector3d base = point == "head"   ? marker("Head")
                        : point == "hand" ? Finger(side, 3, 1)
                        : is_middle       ? marker(point)
                                          : own(point);
  return Moved(base, front, up, is_left ? out : -out);
}

core::PointCloud PointsOf(const Convention& convention, const std::vector<ConventionBody>& bodies) {
  core::PointCloud points{.names = convention.joints, .parents = {}, .frames = {}, .rotations = {}};
  if (convention.is_hierarchy) points.parents = convention.parents;
  for (const ConventionBody& body : bodies) {
    auto& frame = points.frames.emplace_back(3, points.count());
    for (int j = 0; j < points.count(); ++j) frame.col(j) = body.Site(convention.sites[j]);
  }
  return points;
}

}  // namespace motiondb::tests
