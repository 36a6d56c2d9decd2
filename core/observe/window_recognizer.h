// Labels and familiarity of a moving window: Recognize (core/recognition/recognize.h,
// Method::kBest) for streams. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/observe/metric_window.h"
#include "core/observe/observed_states.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

class ClipMask;
class LabelUnits;
class Model;

// A frame is projected into the metric and compared with index nodes and shortlisted clips once,
// when an answer first needs it, and again when it is finished. An answer only sums over its
// frames: the ranking of clips, and the sum over paths of each unit that can be the best of its
// label. Computed without this cache: windows in which a marker is always missing, models without a
// metric (paper's method), and familiarity of models that are not calibrated.
class WindowRecognizer {
 public:
  // The model must outlive this object. `mask`: the clips to use; null: all. `track`: of the
  // labels; empty: kActionTrack.
  WindowRecognizer(const Model& model, int window_frames, double transition_floor,
                   std::shared_ptr<const ClipMask> mask = nullptr, std::string track = {});

  // Equals the result of Recognize for the window, up to rounding.
  struct Answer {
    std::vector<LabelScore> labels;
    std::optional<double> unknown_probability;
    double familiarity = 0;
    std::vector<TrackAnswer> other_tracks;
  };
  // `states`: at least one frame. CANCELLED.
  absl::StatusOr<Answer> Recognize(const ObservedStates& states, const Cancelled& cancelled);
  // Shortlist of the last answer; empty if the cache was not used.
  const std::vector<int>& shortlist() const { return shortlist_; }

  // Forgets all frames; numbering restarts.
  void Restart();

 private:
  absl::StatusOr<Answer> Whole(const ObservedStates& states, const Cancelled& cancelled) const;
  bool ShowsAll(const ObservedStates& states) const;
  double FamiliarityByGraph(const ObservedStates& states) const;
  // Selects the compared frames of the window and their ring indices.
  void ChooseFrames(const ObservedStates& states);
  // Compares the shortlisted clips with each frame.
  absl::Status CompareClips(const ObservedStates& states, const Cancelled& cancelled);
  CachedClip& Keep(int clip);
  // Returns the units that determine each label's evidence, as LabelEvidence uses them; all units
  // if there are other tracks.
  std::vector<UnitEvidence> DecisiveUnits();
  double LogEvidence(const CachedClip& clip, RowRange rows);
  double Noise(const ObservedStates& states);
  double FamiliarityScore();

  int Width(const ObservedStates& states) const;

  const Model& model_;
  const int window_frames_;
  const double transition_floor_;
  const std::shared_ptr<const ClipMask> mask_;
  const std::string track_;
  const std::shared_ptr<const LabelUnits> units_;
  std::optional<MetricWindow> window_;  // absent if the model has no metric
  ClipRanking ranking_;
  std::vector<CachedClip> clips_;  // larger than a shortlist, because clips recur
  std::int64_t answers_ = 0;

  // Of the current answer.
  std::vector<std::int64_t> frames_;
  std::vector<std::size_t> rings_;
  std::vector<int> shortlist_;
  std::vector<const CachedClip*> listed_;
  std::vector<NearestFrame> nearest_;
  FrameMatrix before_newest_;  // the window in the metric, without its newest frame
  PathSum paths_;
};

}  // namespace motiondb::core
