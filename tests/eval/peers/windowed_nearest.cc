#include "tests/eval/peers/windowed_nearest.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/eval/observations.h"

namespace motiondb::tests {
namespace {

// Returns the distance of the window [first, first + width) of the observed frames.
double Nearest(const FrameDistances& distances, Eigen::Index first, Eigen::Index width) {
  const Eigen::Index run = std::min(width, distances.squares.cols());
  const float present = distances.present.segment(first, run).sum();
  if (present == 0) return 0;
  double minimum = std::numeric_limits<double>::infinity();
  for (Eigen::Index start = 0; start + run <= distances.squares.cols(); ++start) {
    double sum = 0;
    for (Eigen::Index t = 0; t < run; ++t) sum += distances.squares(first + t, start + t);
    minimum = std::min(minimum, sum);
  }
  return minimum / present;
}

}  // namespace

double NearestWindow(const StoredFrames& stored, const core::FrameMatrix& observed) {
  return Nearest(DistancesTo(stored, observed), 0, observed.rows());
}

absl::Status WindowedNearest::Learn(const ClipSet& training,
                                    const std::vector<std::string>& labels) {
  scale_ = PeerScale(scaling_, training);
  label_count_ = labels.size();
  for (const EvalClip* clip : training) {
    clips_.emplace_back(scale_.Apply(clip->states));
    labels_.push_back(LabelIndex(*clip, labels));
  }
  return absl::OkStatus();
}

std::vector<double> WindowedNearest::Score(const core::StateSequence& observation, Extent) const {
  const core::FrameMatrix observed = scale_.Apply(observation);
  const auto in_frames = [&](double seconds) {
    return std::max<Eigen::Index>(1, std::lround(seconds * observation.frame_rate_hz));
  };
  const Eigen::Index width = std::min(observed.rows(), in_frames(kWindowSeconds));
  const Eigen::Index hop = in_frames(kHopSeconds);
  const Eigen::Index windows = (observed.rows() - width) / hop + 1;
  // [window][label].
  core::FrameMatrix nearest = core::FrameMatrix::Constant(
      windows, static_cast<Eigen::Index>(label_count_), std::numeric_limits<float>::infinity());
  for (std::size_t c = 0; c < clips_.size(); ++c) {
    const FrameDistances distances = DistancesTo(clips_[c], observed);
    for (Eigen::Index w = 0; w < windows; ++w) {
      float& minimum = nearest(w, labels_[c]);
      minimum = std::min(minimum, static_cast<float>(Nearest(distances, w * hop, width)));
    }
  }
  const Eigen::RowVectorXd means = nearest.cast<double>().colwise().mean();
  std::vector<double> scores;
  for (double mean : means) scores.push_back(-mean);
  return scores;
}

double WindowedNearest::model_bytes() const {
  double bytes = 0;
  for (const StoredFrames& clip : clips_) bytes += 4.0 * static_cast<double>(clip.frames.size());
  return bytes;
}

}  // namespace motiondb::tests
