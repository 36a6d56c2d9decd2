// Pairs of corresponding frames: units of one label, aligned in time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

struct LabelUnit;

struct IndexPair {
  int observed = 0;
  int reference = 0;
  friend bool operator==(const IndexPair&, const IndexPair&) = default;
};

// Returns pairs of units of one label: at most 256 observed units, evenly spread over the units
// whose label occurs at least twice, each with at most `max_references` references, evenly spread.
std::vector<IndexPair> UnitPairs(const std::vector<LabelUnit>& units, int max_references = 8);

// Aligns `observed` with `reference` by dynamic time warping (frames x dimensions, about 30 Hz; at
// most the first 512 frames) with squared distances. With each observed frame the reference
// advances by 0, 1 or 2 frames; it starts at one of its first four frames (a later start costs 0.05
// for each dimension and frame) and ends anywhere. Returns one pair of rows for each observed
// frame, in order of time; empty if the reference is too short. `dimensions`: number of dimensions
// for the cost of a later start, if the columns are projections of more dimensions.
// O(frames^2 * dimensions).
std::vector<IndexPair> AlignFrames(const FrameMatrix& observed, const FrameMatrix& reference,
                                   Eigen::Index dimensions);
inline std::vector<IndexPair> AlignFrames(const FrameMatrix& observed,
                                          const FrameMatrix& reference) {
  return AlignFrames(observed, reference, observed.cols());
}

// Returns the squared Euclidean distances, rows of `a` x rows of `b`. The rounding error is
// proportional to the squared norms, so distances much smaller than the norms are inexact.
inline FrameMatrix SquaredDistances(const Eigen::Ref<const FrameMatrix>& a,
                                    const Eigen::Ref<const FrameMatrix>& b,
                                    const Eigen::Ref<const Eigen::VectorXf>& b_squared_norms) {
  FrameMatrix squared = -2 * a * b.transpose();
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b_squared_norms.transpose();
  return squared.cwiseMax(0);
}

}  // namespace motiondb::core
