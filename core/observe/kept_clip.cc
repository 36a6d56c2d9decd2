#include "core/observe/kept_clip.h"

#include <algorithm>

#include "core/model/model.h"
#include "core/recognition/alignment_loops.h"

namespace motiondb::core {

void KeptClip::Take(const Model& model, int clip, int window_frames) {
  clip_ = clip;
  version_.assign(window_frames, -1);
  nearest_.resize(window_frames);
  const Eigen::Index count = model.metric_frames().rows.count(clip);
  roots_.resize(count, window_frames);
  distances_.resize(count);
}

const NearestFrame& KeptClip::See(const Model& model, std::size_t ring, const MetricFrame& frame) {
  if (version_[ring] == frame.version) return nearest_[ring];
  version_[ring] = frame.version;
  const MetricFrames& stored = model.metric_frames();
  const Eigen::Index first = stored.rows.begin[clip_];
  const Eigen::Index count = stored.rows.count(clip_);
  SquaredDistancesOfOne(stored.projected.row(first).data(), stored.squared_norms.data() + first,
                        static_cast<int>(count), static_cast<int>(frame.projected.size()),
                        frame.projected.data(), frame.squared_norm, distances_.data());
  const float least = Least(distances_.data(), static_cast<int>(count));
  const auto nearest = std::find(distances_.begin(), distances_.end(), least) - distances_.begin();
  nearest_[ring] = {least, stored.rows.frame[first + nearest]};
  PathSum::Roots(distances_, least, roots_.col(static_cast<Eigen::Index>(ring)));
  return nearest_[ring];
}

bool KeptClip::LogEvidence(std::span<const std::size_t> rings, PathSum& paths,
                           double& log_evidence) const {
  paths.Begin(roots_.rows(), false);
  for (const std::size_t ring : rings) {
    paths.SeeRoots(roots_.col(static_cast<Eigen::Index>(ring)), nearest_[ring].squared_distance);
  }
  log_evidence = paths.LogEvidence();
  return paths.IsExact();
}

double KeptClip::LogEvidenceAtMost(std::span<const std::size_t> rings) const {
  double sum = 0;
  for (const std::size_t ring : rings) sum += nearest_[ring].squared_distance;
  return PathSum::LogEvidenceAtMost(roots_.rows(), sum);
}

}  // namespace motiondb::core
