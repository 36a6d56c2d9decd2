#include "core/recognition/clip_alignment.h"

#include <algorithm>

#include "core/model/squared_distances.h"
#include "core/recognition/path_sum.h"

namespace motiondb::core {
namespace {

constexpr Eigen::Index kRows = 64;  // observed frames whose distances are computed at a time

}  // namespace

ClipAlignment AlignToClip(const MetricFrames& stored, int clip, const FrameMatrix& observed,
                          bool anchored) {
  const Eigen::Index first = stored.rows.begin[clip];
  const Eigen::Index count = stored.rows.count(clip);
  PathSum paths;
  paths.Begin(count, anchored);
  ClipAlignment alignment;
  for (Eigen::Index begin = 0; begin < observed.rows(); begin += kRows) {
    const FrameMatrix squared = SquaredDistances(
        observed.middleRows(begin, std::min(kRows, observed.rows() - begin)),
        stored.projected.middleRows(first, count), stored.squared_norms.segment(first, count));
    for (Eigen::Index t = 0; t < squared.rows(); ++t) {
      const auto distances = squared.row(t).transpose().array();
      Eigen::Index nearest = 0;
      const float distance = distances.minCoeff(&nearest);
      alignment.nearest.push_back({distance, stored.rows.frame[first + nearest]});
      paths.See(distances);
    }
  }
  alignment.log_evidence = paths.LogEvidence();
  return alignment;
}

}  // namespace motiondb::core
