// A peer whose parameters, and the conversion of its scores to probabilities, are chosen by
// cross-validation on the training clips.
#pragma once

#include <optional>

#include "tests/eval/recognizers/recognizer.h"
#include "tests/eval/recognizers/unknown_regression.h"

namespace motiondb::tests {

struct PeerCandidate {
  std::string description;
  std::function<std::unique_ptr<Peer>()> make;
};

class TunedPeer : public Recognizer {
 public:
  explicit TunedPeer(std::vector<PeerCandidate> candidates) : candidates_(std::move(candidates)) {}

  // Selects the candidate with the best held-out accuracy (the first of equals) and the temperature
  // with the maximum likelihood of the held-out labels; fits the probability of unknown motion to
  // clips held out by subject; then learns all clips.
  absl::Status Fit(const ClipSet& training, Extent extent) override;
  // Familiarity is the best score, not a probability. The probability of unknown motion is absent
  // if it cannot be fitted or if the extent is not that of Fit, because scores then differ.
  absl::StatusOr<Recognition> Recognize(const core::StateSequence& observation,
                                        Extent extent) const override;
  const std::vector<std::string>& labels() const override { return labels_; }
  std::string chosen_by() const override { return chosen_by_; }
  std::string parameters() const override { return parameters_; }
  double model_bytes() const override { return peer_->model_bytes(); }
  // The temperature and the probability of unknown motion are still fitted.
  std::unique_ptr<Recognizer> WithSameParameters() const override {
    return std::make_unique<TunedPeer>(std::vector<PeerCandidate>{*chosen_});
  }

 private:
  const std::vector<PeerCandidate> candidates_;
  std::vector<std::string> labels_;
  const PeerCandidate* chosen_ = nullptr;  // of candidates_
  std::unique_ptr<Peer> peer_;
  Extent extent_ = Extent::kWhole;
  double temperature_ = 1;
  std::optional<UnknownRegression> unknown_;
  std::string chosen_by_;
  std::string parameters_;
};

}  // namespace motiondb::tests
