// The units of recognition: labelled spans of clips on one track, and the frames between spans.
// A query aligns its observation with units. Pairs of units of one label, aligned in time, are the
// samples from which the metric is learned.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/metric_frames.h"
#include "core/motion/matrix.h"

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

// Two corresponding units or frames.
struct IndexPair {
  int observed = 0;
  int reference = 0;
  friend bool operator==(const IndexPair&, const IndexPair&) = default;
};

// Returns pairs of units of one label: at most 256 observed units, evenly spread over the units
// whose label occurs at least twice, each with at most `max_references` references, evenly spread.
std::vector<IndexPair> UnitPairs(const std::vector<LabelUnit>& units, int max_references = 8);

// Aligns `observed` with `reference` by dynamic time warping (frames x dimensions, about 30 Hz; at
// most the first 512 frames) with squared distances. With each observed frame the reference
// advances by 0, 1 or 2 frames; it starts at one of its first four frames (a later start costs 0.05
// for each dimension and frame) and ends anywhere. Returns one pair of rows for each observed
// frame, in order of time; empty if the reference is too short. `dimensions`: number of dimensions
// for the cost of a later start, if the columns are projections of more dimensions.
// O(frames^2 * dimensions).
std::vector<IndexPair> AlignFrames(const FrameMatrix& observed, const FrameMatrix& reference,
                                   Eigen::Index dimensions);
inline std::vector<IndexPair> AlignFrames(const FrameMatrix& observed,
                                          const FrameMatrix& reference) {
  return AlignFrames(observed, reference, observed.cols());
}

}  // namespace motiondb::core
