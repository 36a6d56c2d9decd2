// From clips to labels. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

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
