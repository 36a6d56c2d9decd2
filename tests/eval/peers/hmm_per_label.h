// Peer: one hidden Markov model a label; the label whose model makes the observation likeliest.
#pragma once

#include "tests/eval/peers/gaussian_hmm.h"
#include "tests/eval/peers/peer.h"

namespace motiondb::tests {

class HmmPerLabel : public Peer {
 public:
  explicit HmmPerLabel(const HmmOptions& options) : options_(options) {}

  absl::Status Learn(const ClipSet& training, const std::vector<std::string>& labels) override;
  // The log likelihood a frame. A window may begin in any state.
  std::vector<double> Score(const core::StateSequence& observation, Extent extent) const override;
  double model_bytes() const override;

 private:
  const HmmOptions options_;
  PeerScale scale_;
  std::vector<GaussianHmm> models_;  // one a label
};

}  // namespace motiondb::tests
