#include "tests/eval/recognizers/tuned_peer.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/recognizers/cross_validation.h"

namespace motiondb::tests {

absl::Status TunedPeer::Fit(const ClipSet& training, Extent extent) {
  labels_ = LabelsOf(training);
  const Folds folds = MakeFolds(training);
  double best_accuracy = -1;
  const PeerCandidate* best = nullptr;
  for (const PeerCandidate& candidate : candidates_) {
    std::vector<HeldOut> held_out;
    for (const Fold& fold : folds.folds) {
      const std::unique_ptr<Peer> peer = candidate.make();
      MOTIONDB_RETURN_IF_ERROR(peer->Learn(fold.training, labels_));
      for (const EvalClip* clip : fold.test) {
        const int truth = LabelIndex(*clip, labels_);
        for (const core::StateSequence& states : SplitIntoParts(clip->states, extent)) {
          held_out.push_back({peer->Score(states, extent), truth});
        }
      }
    }
    const double accuracy = HeldOutAccuracy(held_out);
    if (accuracy > best_accuracy) {
      best_accuracy = accuracy;
      best = &candidate;
      temperature_ = BestTemperature(held_out);
    }
  }
  peer_ = best->make();
  chosen_by_ = folds.description + " on the training clips";
  parameters_ = fmt::format("{} ({:.1f} % right), temperature {:.2g}", best->description,
                            100 * best_accuracy, temperature_);
  return peer_->Learn(training, labels_);
}

absl::StatusOr<Recognition> TunedPeer::Recognize(const core::StateSequence& observation,
                                                 Extent extent) const {
  const std::vector<double> scores = peer_->Score(observation, extent);
  const auto best = std::max_element(scores.begin(), scores.end());
  return Recognition{labels_[best - scores.begin()], Softmax(scores, temperature_), *best};
}

}  // namespace motiondb::tests
