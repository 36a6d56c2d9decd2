// What the last moments of a stream are called and how familiar they are: Recognize
// (core/recognition/recognize.h, Method::kBest) of one window, which moves along. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/observe/metric_window.h"
#include "core/observe/observed_states.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class Model;

// A frame is brought into the metric and compared with the index's nodes and the shortlisted clips
// once, when an answer first needs it, and once more when it is finished. What is left for an
// answer is to add up what its frames say: the ranking of clips, and for a clip the sum over paths,
// which is passed over where the clip cannot be the best of its label. Computed whole are windows
// that never show some marker, which is then left out, those by the paper, for a model without a
// metric, and familiarity in a model that was not calibrated.
class WindowRecognizer {
 public:
  // The model must outlive it.
  WindowRecognizer(const Model& model, int window_frames, double transition_floor);

  // The same labels, familiarity and shortlist, to rounding, as Recognize gives for the window.
  struct Answer {
    std::vector<LabelScore> labels;
    double familiarity = 0;
  };
  // `states` has a frame at least. CANCELLED, asked once a clip.
  absl::StatusOr<Answer> Recognize(const ObservedStates& states, const Cancelled& cancelled);
  // Of the last answer; empty if its window was computed whole.
  const std::vector<int>& shortlist() const { return shortlist_; }

  // Frames are numbered anew.
  void Restart();

 private:
  absl::StatusOr<Answer> Whole(const ObservedStates& states, const Cancelled& cancelled) const;
  bool ShowsAll(const ObservedStates& states) const;
  double FamiliarityByGraph(const ObservedStates& states) const;
  // Which frames of the window are compared, and where they are in the rings.
  void ChooseFrames(const ObservedStates& states);
  // The shortlisted clips, each beside each frame.
  absl::Status CompareClips(const ObservedStates& states, const Cancelled& cancelled);
  KeptClip& Keep(int clip);
  // The clips that settle what is known of each label, as LabelEvidence uses them.
  std::vector<ClipEvidence> DecisiveClips();
  double LogEvidence(const KeptClip& clip);
  double FamiliarityScore();

  int Width(const ObservedStates& states) const;

  const Model& model_;
  const int window_frames_;
  const double transition_floor_;
  std::vector<std::string> labels_;
  std::vector<int> label_of_clip_;
  std::optional<MetricWindow> window_;  // absent where the model has no metric
  ClipRanking ranking_;
  std::vector<KeptClip> clips_;  // more than a shortlist has, for clips come and go
  std::int64_t answers_ = 0;

  // Of the answer at hand.
  std::vector<std::int64_t> frames_;
  std::vector<std::size_t> rings_;
  std::vector<int> shortlist_;
  std::vector<const KeptClip*> listed_;
  std::vector<NearestFrame> nearest_;
  PathSum paths_;
};

}  // namespace motiondb::core
