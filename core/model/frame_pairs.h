// Which frames of stored clips show the same moment of one behaviour: clips of one label, brought
// together in time. Pure functions; safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

struct ModelClip;

struct IndexPair {
  int observed = 0;
  int reference = 0;
  friend bool operator==(const IndexPair&, const IndexPair&) = default;
};

// Pairs of clips of one label. At most 256 clips are observed, spread evenly over those whose label
// has another, each with at most `most_references` references, spread evenly: the work is bounded.
std::vector<IndexPair> ClipPairs(const std::vector<ModelClip>& clips, int most_references = 8);

// Dynamic time warping of all of `observed` onto `reference` (frames x dimensions, some 30 a
// second; the first 512 frames of it): squared distances, with each observed frame the reference
// moves on by 0, 1 or 2, starts at one of its first four frames (a later start costs 0.05 a
// dimension and frame) and ends anywhere. One pair of rows for each observed frame, in order of
// time; none where the reference is too short. O(frames * frames * dimensions). Columns may stand
// for more dimensions than they are, which a later start is then paid for.
std::vector<IndexPair> AlignFrames(const FrameMatrix& observed, const FrameMatrix& reference,
                                   Eigen::Index dimensions);
inline std::vector<IndexPair> AlignFrames(const FrameMatrix& observed,
                                          const FrameMatrix& reference) {
  return AlignFrames(observed, reference, observed.cols());
}

// Squared Euclidean distances, rows of `a` x rows of `b`, whose squared norms are given. Rounding
// is that of the norms: a distance far below them is only known to be small.
inline FrameMatrix SquaredDistances(const Eigen::Ref<const FrameMatrix>& a,
                                    const Eigen::Ref<const FrameMatrix>& b,
                                    const Eigen::Ref<const Eigen::VectorXf>& b_squared_norms) {
  FrameMatrix squared = -2 * a * b.transpose();
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b_squared_norms.transpose();
  return squared.cwiseMax(0);
}

}  // namespace motiondb::core
