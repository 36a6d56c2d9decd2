// A peer whose parameters, and the conversion of its scores to probabilities, are chosen by
// cross-validation on the training clips.
#pragma once

#include "tests/eval/recognizers/recognizer.h"

namespace motiondb::tests {

struct PeerCandidate {
  std::string description;
  std::function<std::unique_ptr<Peer>()> make;
};

class TunedPeer : public Recognizer {
 public:
  explicit TunedPeer(std::vector<PeerCandidate> candidates) : candidates_(std::move(candidates)) {}

  // Selects the candidate with the best held-out accuracy (the first of equals) and the temperature
  // with the maximum likelihood of the held-out labels; then learns all clips.
  absl::Status Fit(const ClipSet& training, Extent extent) override;
  // Familiarity is the best score, not a probability.
  absl::StatusOr<Recognition> Recognize(const core::StateSequence& observation,
                                        Extent extent) const override;
  const std::vector<std::string>& labels() const override { return labels_; }
  std::string chosen_by() const override { return chosen_by_; }
  std::string parameters() const override { return parameters_; }
  double model_bytes() const override { return peer_->model_bytes(); }

 private:
  const std::vector<PeerCandidate> candidates_;
  std::vector<std::string> labels_;
  std::unique_ptr<Peer> peer_;
  double temperature_ = 1;
  std::string chosen_by_;
  std::string parameters_;
};

}  // namespace motiondb::tests
