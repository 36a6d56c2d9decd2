// Alignment of one window with stored units, and label probabilities from it.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

class ClipMask;
class LabelUnits;
struct LabelUnit;
class Model;

struct UnitEvidence {
  const LabelUnit* unit = nullptr;
  double log_evidence = 0;  // natural logarithm, sum over the frames
};

struct WindowAlignment {
  std::vector<UnitEvidence> units;  // in descending order of evidence
  int frames = 0;                   // number of compared frames
  double noise = 0;  // part of each frame's squared distances that is noise (NoiseEnergy)
  // Similarity to the stored clips: negative logarithm of the mean, over frames and dimensions, of
  // the squared whitened difference from the nearest stored motion (NearestState).
  double familiarity_score = 0;
};

// Sorts by descending evidence; stable.
void SortByEvidence(std::vector<UnitEvidence>& units);

// Returns the familiarity score of a mean squared whitened difference.
double FamiliarityOfDifference(double mean_square);

// Returns the stored motion that differs least from `state` (scaled, without NaN), less than a
// stride (FrameStride) from frame `nearest` of the same clip: alignment sees only strided frames.
// Between frames it is interpolated, because the same motion can be sampled at other times.
Eigen::RowVectorXf NearestState(const Model& model, int nearest,
                                const Eigen::Ref<const Eigen::RowVectorXf>& state);

// Returns stored `rows` (of the model's metric frames) in another metric, as the rows from 0.
MetricFrames ProjectStridedRows(const Model& model, const MotionMetric& metric, RowRange rows);

// Aligns the observation's frames `compared` (ComparedFrames) with the units of each shortlisted
// clip, except those of `left_out_label`. `mask`: the clips to use, with units in `units`; null:
// all. `anchored` as for AlignToClip. CANCELLED. REQUIRES: a unit remains.
absl::StatusOr<WindowAlignment> AlignWindow(const Model& model, const LabelUnits& units,
                                            const MetricObservation& observation,
                                            const std::vector<int>& compared, const ClipMask* mask,
                                            bool anchored, const Cancelled& cancelled,
                                            int left_out_label = -1);

// Returns the clips of the units, in the order of their best units.
std::vector<ClipScore> ClipsOf(const LabelUnits& units, const std::vector<UnitEvidence>& evidence);

// Returns P(label | window) by generation probabilities (kPaper), with a uniform prior over the
// labels and over the units of a label. Uniform if no unit can generate the window. Most probable
// first.
std::vector<LabelScore> LabelsByGeneration(const std::vector<std::string>& labels,
                                           const std::vector<UnitEvidence>& units);

// Returns for each of `label_count` labels the evidence of its best aligned unit. A label without
// an aligned unit gets the lowest evidence of all aligned units, because the shortlist may have
// missed it.
std::vector<double> LabelEvidence(std::size_t label_count, const std::vector<UnitEvidence>& units);

// Returns P(label | window) by alignment: proportional to exp(weight * evidence). `evidence`:
// LabelEvidence of `labels`. Most probable first.
std::vector<LabelScore> LabelsByAlignment(const std::vector<std::string>& labels,
                                          std::vector<double> evidence, double weight);

// Returns the labels of the other tracks. A unit has a probability proportional to exp(weight *
// evidence), all units together `known`; it is divided among the labels that its frames have on a
// track, by their numbers of frames, and no label.
std::vector<TrackAnswer> OtherTracks(const Model& model, const LabelUnits& units,
                                     const std::vector<UnitEvidence>& evidence, double weight,
                                     double known);

}  // namespace motiondb::core
