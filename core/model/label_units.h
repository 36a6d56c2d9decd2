// The units of recognition: labelled spans of clips on one track, and the frames between spans.
// A query aligns its observation with units.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/metric_frames.h"

namespace motiondb::core {

class ClipMask;
class Model;
struct ModelClip;

struct LabelUnit {
  int clip = 0;
  int label = -1;       // index into LabelUnits::labels(); -1: none
  int first_frame = 0;  // of the model
  int frame_count = 0;
  // Its strided frames. A unit between two strided frames has the one before it.
  RowRange rows;
};

// Immutable and thread-safe.
class LabelUnits {
 public:
  // Units of the clips that `mask` allows (null: all), in the order of their frames. O(clips +
  // spans).
  LabelUnits(const std::vector<ModelClip>& clips, double frame_rate_hz, std::string_view track,
             const ClipMask* mask = nullptr);

  // Labels of the used clips, in alphabetical order.
  const std::vector<std::string>& labels() const { return labels_; }
  // Name of a unit's label; empty if it has none.
  const std::string& NameOf(int label) const { return label < 0 ? no_label_ : labels_[label]; }
  const std::vector<LabelUnit>& all() const { return units_; }
  // Units of a clip, at least one; none if it is not used.
  std::span<const LabelUnit> of_clip(int clip) const {
    return std::span(units_).subspan(begin_[clip], begin_[clip + 1] - begin_[clip]);
  }
  // Other tracks of the used clips, ascending.
  const std::vector<std::string>& other_tracks() const { return other_tracks_; }

 private:
  const std::string no_label_;
  std::vector<std::string> labels_;
  std::vector<LabelUnit> units_;
  std::vector<int> begin_;
  std::vector<std::string> other_tracks_;
};

// Returns the units of the clips that `mask` allows (null: all), on a track (empty: kActionTrack).
// Those of kActionTrack are computed once for each model and mask.
std::shared_ptr<const LabelUnits> UnitsOf(const Model& model, std::string_view track,
                                          const ClipMask* mask = nullptr);

}  // namespace motiondb::core
