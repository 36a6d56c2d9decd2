// What stored clips, compared frame by frame, say about one window. Safe to call from any thread.
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
  double log_evidence = 0;  // natural, summed over the frames
};

struct WindowAlignment {
  std::vector<ClipEvidence> clips;  // most evidence first
  int frames = 0;                   // of the observation that were compared
  // How like the stored clips the window is: the negative log of the mean, over frames and
  // dimensions, of the squared whitened difference to the nearest stored frame.
  double familiarity_score = 0;
};

// Puts those with most evidence first; those with the same keep their order.
void SortByEvidence(std::vector<ClipEvidence>& clips);

// A familiarity score from the mean of the squared whitened differences.
double FamiliarityOfDifference(double mean_square);

// Aligns the observation's frames `compared` (ComparedFrames) with each clip that is on its
// shortlist, among those that are not left out (one at least is not). `anchored` as for
// AlignToClip. CANCELLED, soon.
absl::StatusOr<WindowAlignment> AlignWindow(const Model& model,
                                            const MetricObservation& observation,
                                            const std::vector<int>& compared,
                                            const std::vector<bool>& left_out, bool anchored,
                                            const Cancelled& cancelled);

// From clips to labels. Safe to call from any thread.

// P(label | window) by the paper: labels alike beforehand, and the clips of a label too. Uniform
// where no clip can generate the window. Most probable first.
std::vector<LabelScore> LabelsByGeneration(const Model& model, const std::vector<ClipScore>& clips);

// The labels of a model's clips, each once, in order of name.
std::vector<std::string> Labels(const Model& model);

// What the aligned clips of each label say: that of the best. A label none of whose clips was
// aligned, so that the graphs found them all less probable, is held to be like the poorest clip
// that was: not impossible, for the graphs may err.
std::vector<double> LabelEvidence(const Model& model, const std::vector<std::string>& labels,
                                  const std::vector<ClipEvidence>& clips);

// P(label | window) by alignment: proportional to exp(weight * evidence). `labels`: Labels(model).
// Most probable first.
std::vector<LabelScore> LabelsByAlignment(const Model& model,
                                          const std::vector<std::string>& labels,
                                          const WindowAlignment& alignment,
                                          const EvidenceWeight& weight);

}  // namespace motiondb::core
