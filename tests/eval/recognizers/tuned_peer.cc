#include "tests/eval/recognizers/tuned_peer.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/motion/error.h"
#include "tests/eval/observations.h"
#include "tests/eval/recognizers/cross_validation.h"

namespace motiondb::tests {
namespace {

// Scores the test clips of every fold with a peer that learned its training clips.
absl::StatusOr<std::vector<HeldOut>> ScoreFolds(const PeerCandidate& candidate,
                                                const std::vector<Fold>& folds,
                                                const std::vector<std::string>& labels,
                                                Extent extent) {
  std::vector<HeldOut> held_out;
  int clips = 0;
  for (const Fold& fold : folds) {
    const std::vector<std::string> learned = LabelsOf(fold.training);
    if (learned.empty()) continue;
    const std::unique_ptr<Peer> peer = candidate.make();
    MOTIONDB_RETURN_IF_ERROR(peer->Learn(fold.training, learned));
    for (const EvalClip* clip : fold.test) {
      for (const core::StateSequence& states : SplitIntoParts(clip->states, extent)) {
        const std::vector<double> scores = peer->Score(states, extent);
        HeldOut& motion = held_out.emplace_back();
        motion.scores.assign(labels.size(), -std::numeric_limits<double>::infinity());
        for (std::size_t l = 0; l < learned.size(); ++l) {
          const auto at = std::ranges::lower_bound(labels, learned[l]);
          motion.scores[static_cast<std::size_t>(at - labels.begin())] = scores[l];
        }
        motion.truth = LabelIndex(*clip, labels);
        motion.clip = clips;
      }
      ++clips;
    }
  }
  return held_out;
}

}  // namespace

absl::Status TunedPeer::Fit(const ClipSet& training, Extent extent) {
  labels_ = LabelsOf(training);
  extent_ = extent;
  const Folds folds = MakeFolds(training);
  double best_accuracy = -1;
  std::vector<HeldOut> best_held_out;
  for (const PeerCandidate& candidate : candidates_) {
    MOTIONDB_ASSIGN_OR_RETURN(std::vector<HeldOut> held_out,
                              ScoreFolds(candidate, folds.folds, labels_, extent));
    const double accuracy = HeldOutAccuracy(held_out);
    if (accuracy > best_accuracy) {
      best_accuracy = accuracy;
      chosen_ = &candidate;
      best_held_out = std::move(held_out);
    }
  }
  temperature_ = BestTemperature(best_held_out);
  if (!folds.by_source) {
    MOTIONDB_ASSIGN_OR_RETURN(best_held_out,
                              ScoreFolds(*chosen_, LeaveOneSourceOut(training), labels_, extent));
  }
  unknown_ = FitUnknownRegression(best_held_out, temperature_);
  peer_ = chosen_->make();
  chosen_by_ = folds.description + " on the training clips";
  parameters_ = fmt::format("{} ({:.1f} % right), temperature {:.2g}{}", chosen_->description,
                            100 * best_accuracy, temperature_,
                            unknown_ ? "" : ", never unknown: too few clips");
  return peer_->Learn(training, labels_);
}

absl::StatusOr<Recognition> TunedPeer::Recognize(const core::StateSequence& observation,
                                                 Extent extent) const {
  const std::vector<double> scores = peer_->Score(observation, extent);
  const auto best = std::max_element(scores.begin(), scores.end());
  Recognition recognition{labels_[best - scores.begin()], Softmax(scores, temperature_), *best};
  if (unknown_ && extent == extent_) {
    recognition.unknown_probability = unknown_->Probability(scores);
    for (double& probability : recognition.probabilities) {
      probability *= 1 - *recognition.unknown_probability;
    }
  }
  return recognition;
}

}  // namespace motiondb::tests
