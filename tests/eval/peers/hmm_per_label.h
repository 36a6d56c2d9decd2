// Peer: one hidden Markov model per label; the label with the highest likelihood wins.
#pragma once

#include "tests/eval/peers/gaussian_hmm.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

class HmmPerLabel : public Peer {
 public:
  explicit HmmPerLabel(const HmmOptions& options) : options_(options) {}

  absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) override;
  // Returns log likelihoods per frame. A window may start in any state.
  std::vector<double> Score(const core::StateSequence& observation, Extent extent) const override;
  double model_bytes() const override;

 private:
  const HmmOptions options_;
  PeerScale scale_;
  std::vector<GaussianHmm> models_;  // one per label
};

}  // namespace motiondb::tests
