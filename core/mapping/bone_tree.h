// The hierarchy of a motion as a tree of bones with lengths, for the search of a figure in it.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "core/mapping/figure.h"

namespace motiondb::core {

// Returns the Gaussian of a deviation, 1 at 0.
inline double Bell(double deviation, double tolerance) {
  return std::exp(-(deviation / tolerance) * (deviation / tolerance) / 2);
}

// Distance of two joints over the frames.
struct Bone {
  double length = 0;     // mean
  double variation = 0;  // standard deviation, relative to the mean
};

class BoneTree {
 public:
  // Lengths are medians over the frames. REQUIRES: points.parents is not empty; points outlive
  // this.
  BoneTree(const PointCloud& points, const std::vector<NameMeaning>& meanings);

  int count() const { return static_cast<int>(length_.size()); }
  int parent(int joint) const { return points_->parents[joint]; }
  std::span<const int> children(int joint) const { return children_[joint]; }
  // Length of the bone from the parent; 0 for a root.
  double length(int joint) const { return length_[joint]; }
  // Length of the longest path down from the joint; accessories count a fifth.
  double reach(int joint) const { return reach_[joint]; }
  bool IsAncestor(int ancestor, int joint) const;
  // Path down from `joint`, at each branching along the longest way.
  std::vector<int> LongestPath(int joint) const;
  // Joints from `from` to `to` through their lowest common ancestor, both included; empty if they
  // have different roots.
  std::vector<int> Path(int from, int to) const;
  double PathLength(std::span<const int> path) const;

  Bone MeasureBone(int begin, int end) const;
  // Largest change of the angle between two bones that meet in `middle` (rad), over the frames.
  double BendingRange(int begin, int middle, int end) const;

  const PointCloud& points() const { return *points_; }
  const NameMeaning& meaning(int joint) const { return (*meanings_)[joint]; }

 private:
  // Length of the longest path from the parent down through `joint`.
  double way(int joint) const;

  const PointCloud* points_;
  const std::vector<NameMeaning>* meanings_;
  std::vector<std::vector<int>> children_;
  std::vector<double> length_;
  std::vector<double> reach_;
};

}  // namespace motiondb::core
