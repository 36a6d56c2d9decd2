#include "core/recognition/clip_alignment.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/motion/patience.h"
#include "core/recognition/alignment_loops.h"

namespace motiondb::core {
namespace {

// Of a block of observed frames with so many stored ones.
std::int64_t StepsOfBlock(const MetricFrames& stored, int count) {
  return std::int64_t{count} * stored.projected.cols();
}

}  // namespace

ClipAligner::ClipAligner(const FrameMatrix& observed, bool anchored)
    : frames_(static_cast<int>(observed.rows())), anchored_(anchored) {
  const int blocks = (frames_ + kFrameLanes - 1) / kFrameLanes;
  observed_norms_.setZero(blocks * kFrameLanes);
  observed_norms_.head(frames_) = observed.rowwise().squaredNorm();
  for (int block = 0; block < blocks; ++block) {
    FrameMatrix& lanes = observed_.emplace_back(FrameMatrix::Zero(observed.cols(), kFrameLanes));
    lanes.leftCols(FramesOf(block)) =
        observed.middleRows(block * kFrameLanes, FramesOf(block)).transpose();
  }
}

int ClipAligner::FramesOf(int block) const {
  return std::min(kFrameLanes, frames_ - block * kFrameLanes);
}

void ClipAligner::ComputeDistances(const MetricFrames& stored, int first, int count, int block) {
  SquaredDistances(stored.projected.row(first).data(), stored.squared_norms.data() + first, count,
                   static_cast<int>(stored.projected.cols()), observed_[block].data(),
                   observed_norms_.data() + block * kFrameLanes, FramesOf(block), distances_.data(),
                   count);
}

double ClipAligner::LogEvidenceByDistances(const MetricFrames& stored, int first, int count,
                                           Patience& patience) {
  paths_.Begin(count, anchored_);
  for (int block = 0; block * kFrameLanes < frames_; ++block) {
    if (patience.IsOver(StepsOfBlock(stored, count))) return 0;
    ComputeDistances(stored, first, count, block);
    for (int f = 0; f < FramesOf(block); ++f) paths_.See(distances_.col(f));
  }
  return paths_.LogEvidence();
}

double ClipAligner::Align(const MetricFrames& stored, int clip, std::vector<NearestFrame>& nearest,
                          const Cancelled& cancelled) {
  Patience patience(cancelled);
  const int first = stored.rows.begin[clip];
  const int count = stored.rows.count(clip);
  distances_.resize(count, kFrameLanes);
  roots_.resize(count);
  paths_.Begin(count, anchored_);
  for (int block = 0; block * kFrameLanes < frames_; ++block) {
    if (patience.IsOver(StepsOfBlock(stored, count))) return 0;
    ComputeDistances(stored, first, count, block);
    for (int f = 0; f < FramesOf(block); ++f) {
      const auto distances = distances_.col(f);
      const float least = Least(distances.data(), count);
      NearestFrame& so_far = nearest[block * kFrameLanes + f];
      if (least < so_far.squared_distance) {
        const auto at = std::find(distances.begin(), distances.end(), least) - distances.begin();
        so_far = {least, stored.rows.frame[first + at]};
      }
      const bool cut_off = PathSum::Roots(distances, least, roots_);
      paths_.SeeRoots(roots_, least, cut_off);
    }
  }
  return paths_.IsExact() ? paths_.LogEvidence()
                          : LogEvidenceByDistances(stored, first, count, patience);
}

ClipAlignment AlignToClip(const MetricFrames& stored, int clip, const FrameMatrix& observed,
                          bool anchored) {
  ClipAlignment alignment;
  alignment.nearest.assign(observed.rows(), {std::numeric_limits<float>::infinity(), 0});
  alignment.log_evidence = ClipAligner(observed, anchored).Align(stored, clip, alignment.nearest);
  return alignment;
}

}  // namespace motiondb::core
