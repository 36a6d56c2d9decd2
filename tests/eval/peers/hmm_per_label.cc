#include "tests/eval/peers/hmm_per_label.h"

namespace motiondb::tests {

absl::Status HmmPerLabel::Learn(const ClipSet& training, const std::vector<std::string>& labels) {
  scale_ = PeerScale(core::Scaling::kKind, training);
  std::vector<std::vector<GaussianHmm::Sequence>> of_label(labels.size());
  for (const EvalClip* clip : training) {
    of_label[LabelIndex(*clip, labels)].push_back(scale_.Apply(clip->states).cast<double>());
  }
  for (const auto& sequences : of_label) models_.push_back(GaussianHmm::Fit(sequences, options_));
  return absl::OkStatus();
}

std::vector<double> HmmPerLabel::Score(const core::StateSequence& observation,
                                       Extent extent) const {
  const GaussianHmm::Sequence observed = scale_.Apply(observation).cast<double>();
  std::vector<double> scores;
  for (const GaussianHmm& model : models_) {
    scores.push_back(model.LogLikelihood(observed, extent == Extent::kWindow) /
                     static_cast<double>(observed.rows()));
  }
  return scores;
}

double HmmPerLabel::model_bytes() const {
  double bytes = 0;
  for (const GaussianHmm& model : models_) bytes += 8 * model.parameter_count();
  return bytes;
}

}  // namespace motiondb::tests
