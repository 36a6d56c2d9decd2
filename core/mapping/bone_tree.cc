#include "core/mapping/bone_tree.h"

#include <algorithm>
#include <cmath>

#include "core/motion/samples.h"

namespace motiondb::core {
namespace {

constexpr double kAccessoryWeight = 0.2;

}  // namespace

BoneTree::BoneTree(const PointCloud& points, const std::vector<NameMeaning>& meanings)
    : points_(&points),
      meanings_(&meanings),
      children_(points.count()),
      length_(points.count(), 0),
      reach_(points.count(), 0) {
  for (int j = 0; j < count(); ++j) {
    if (parent(j) < 0) continue;
    children_[parent(j)].push_back(j);
    std::vector<double> lengths;
    for (const auto& frame : points.frames) {
      lengths.push_back((frame.col(j) - frame.col(parent(j))).norm());
    }
    length_[j] = Median(lengths);
  }
  for (int j = count() - 1; j >= 0; --j) {
    if (parent(j) < 0) continue;
    reach_[parent(j)] = std::max(reach_[parent(j)], way(j));
  }
}

double BoneTree::way(int joint) const {
  return (meaning(joint).is_accessory ? kAccessoryWeight : 1) * length_[joint] + reach_[joint];
}

bool BoneTree::IsAncestor(int ancestor, int joint) const {
  while (joint > ancestor) joint = parent(joint);
  return joint == ancestor;
}

std::vector<int> BoneTree::LongestPath(int joint) const {
  std::vector<int> path = {joint};
  while (!children_[path.back()].empty()) {
    path.push_back(*std::ranges::max_element(children_[path.back()], {},
                                             [&](int child) { return way(child); }));
  }
  return path;
}

std::vector<int> BoneTree::Path(int from, int to) const {
  std::vector<int> up = {from};
  std::vector<int> down = {to};
  while (up.back() != down.back()) {
    // Parents precede their children.
    std::vector<int>& later = up.back() > down.back() ? up : down;
    const int next = parent(later.back());
    if (next < 0) return {};
    later.push_back(next);
  }
  down.pop_back();
  up.insert(up.end(), down.rbegin(), down.rend());
  return up;
}

double BoneTree::PathLength(std::span<const int> path) const {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    sum += length_[std::max(path[i - 1], path[i])];  // the lower joint of a bone comes later
  }
  return sum;
}

Bone BoneTree::MeasureBone(int begin, int end) const {
  double sum = 0;
  double squares = 0;
  for (const auto& frame : points_->frames) {
    const double distance = (frame.col(end) - frame.col(begin)).norm();
    sum += distance;
    squares += distance * distance;
  }
  const auto count = static_cast<double>(points_->frames.size());
  const double mean = sum / count;
  const double variance = std::max(0.0, squares / count - mean * mean);
  return {mean, mean > 0 ? std::sqrt(variance) / mean : 0};
}

double BoneTree::BendingRange(int begin, int middle, int end) const {
  double least = 10;
  double most = -10;
  for (const auto& frame : points_->frames) {
    const Eigen::Vector3d in = frame.col(middle) - frame.col(begin);
    const Eigen::Vector3d out = frame.col(end) - frame.col(middle);
    const double angle = std::atan2(in.cross(out).norm(), in.dot(out));
    least = std::min(least, angle);
    most = std::max(most, angle);
  }
  return std::max(0.0, most - least);
}

}  // namespace motiondb::core
