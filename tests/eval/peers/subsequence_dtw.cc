#include "tests/eval/peers/subsequence_dtw.h"

#include <algorithm>
#include <limits>

namespace motiondb::tests {

double WarpCost(const core::FrameMatrix& costs, WarpEnds ends) {
  const auto stored = static_cast<std::size_t>(costs.cols());
  std::vector<float> above(stored);
  std::vector<float> row(stored);
  for (Eigen::Index i = 0; i < costs.rows(); ++i) {
    const float* cost = costs.row(i).data();
    if (i == 0) {
      row[0] = cost[0];
      for (std::size_t j = 1; j < stored; ++j) {
        row[j] = cost[j] + (ends.free_start ? 0 : row[j - 1]);
      }
    } else {
      row[0] = cost[0] + above[0];
      for (std::size_t j = 1; j < stored; ++j) {
        row[j] = cost[j] + std::min({row[j - 1], above[j], above[j - 1]});
      }
    }
    row.swap(above);
  }
  return ends.free_end ? *std::min_element(above.begin(), above.end()) : above.back();
}

absl::Status SubsequenceDtw::Learn(const ClipSet& training,
                                   const std::vector<std::string>& labels) {
  scale_ = PeerScale(scaling_, training);
  label_count_ = labels.size();
  for (const EvalClip* clip : training) {
    clips_.emplace_back(scale_.Apply(clip->states));
    labels_.push_back(LabelIndex(*clip, labels));
  }
  return absl::OkStatus();
}

std::vector<double> SubsequenceDtw::Score(const core::StateSequence& observation,
                                          Extent extent) const {
  const core::FrameMatrix observed = scale_.Apply(observation);
  const WarpEnds ends{.free_start = extent == Extent::kWindow,
                      .free_end = extent != Extent::kWhole};
  std::vector<double> scores(label_count_, -std::numeric_limits<double>::infinity());
  for (std::size_t c = 0; c < clips_.size(); ++c) {
    FrameDistances distances = DistancesTo(clips_[c], observed);
    distances.squares.array().colwise() /= distances.present.array().max(1.0F);
    const auto frames = static_cast<double>(
        observed.rows() + (extent == Extent::kWhole ? clips_[c].frames.rows() : 0));
    double& best = scores[labels_[c]];
    best = std::max(best, -WarpCost(distances.squares, ends) / frames);
  }
  return scores;
}

double SubsequenceDtw::model_bytes() const {
  double bytes = 0;
  for (const StoredFrames& clip : clips_) bytes += 4.0 * static_cast<double>(clip.frames.size());
  return bytes;
}

}  // namespace motiondb::tests
