// Alignment of one window with stored clips, and label probabilities from it.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/recognition/metric_observation.h"
#include "core/recognition/recognize.h"

namespace motiondb::core {

class Model;

struct ClipEvidence {
  int clip = 0;             // index into Model::clips()
  double log_evidence = 0;  // natural logarithm, sum over the frames
};

struct WindowAlignment {
  std::vector<ClipEvidence> clips;  // in descending order of evidence
  int frames = 0;                   // number of compared frames
  double energy = 0;  // mean over the frames of the squared distance from the metric's mean
  double noise = 0;   // part of each frame's squared distances that is noise (noise_energy.h)
  // Similarity to the stored clips: negative logarithm of the mean, over frames and dimensions, of
  // the squared whitened difference from the nearest stored motion (NearestState).
  double familiarity_score = 0;
};

// Sorts by descending evidence; stable.
void SortByEvidence(std::vector<ClipEvidence>& clips);

// Returns the familiarity score of a mean squared whitened difference.
double FamiliarityOfDifference(double mean_square);

// Returns the stored motion that differs least from `state` (scaled, without NaN), less than a
// stride (FrameStride) from frame `nearest` of the same clip: alignment sees only strided frames.
// Between frames it is interpolated, because the same motion can be sampled at other times.
Eigen::RowVectorXf NearestState(const Model& model, int nearest,
                                const Eigen::Ref<const Eigen::RowVectorXf>& state);

// Aligns the observation's frames `compared` (ComparedFrames) with each shortlisted clip.
// `anchored` as for AlignToClip. CANCELLED. REQUIRES: at least one clip is not left out.
absl::StatusOr<WindowAlignment> AlignWindow(const Model& model,
                                            const MetricObservation& observation,
                                            const std::vector<int>& compared,
                                            const std::vector<bool>& left_out, bool anchored,
                                            const Cancelled& cancelled);

// Returns P(label | window) by generation probabilities (kPaper), with a uniform prior over the
// labels and over the clips of a label. Uniform if no clip can generate the window. Most probable
// first.
std::vector<LabelScore> LabelsByGeneration(const Model& model, const std::vector<ClipScore>& clips);

// Returns the distinct labels of a model's clips, in alphabetical order.
std::vector<std::string> Labels(const Model& model);
// Returns the index of a clip's label in Labels(model).
std::size_t LabelIndex(const Model& model, const std::vector<std::string>& labels, int clip);

// Returns for each label the evidence of its best aligned clip. A label without an aligned clip
// gets the lowest evidence of the aligned clips, because the shortlist may have missed it.
std::vector<double> LabelEvidence(const Model& model, const std::vector<std::string>& labels,
                                  const std::vector<ClipEvidence>& clips);

// Returns P(label | window) by alignment: proportional to exp(weight * evidence). `labels`:
// Labels(model); `evidence`: their LabelEvidence. Most probable first.
std::vector<LabelScore> LabelsByAlignment(const std::vector<std::string>& labels,
                                          std::vector<double> evidence, double weight);

}  // namespace motiondb::core
