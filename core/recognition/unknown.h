// The probability that a motion is unknown: that it has none of the stored labels.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/model/answer_calibration.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

// What an alignment says about the most probable label.
struct BestLabel {
  std::size_t label = 0;    // index into the labels
  double log_distance = 0;  // LogDistance
  // By how much the LogDistance of the second-best label is larger: at least 0; 0 without a second
  // label.
  double lead = 0;
};

// Returns the natural logarithm of the squared distance that a label's evidence amounts to, mean
// over the frames, in the metric. The noise of the observation, which adds the same amount to the
// squared distances from all motion, is subtracted.
double LogDistance(double evidence, const WindowAlignment& alignment);

// `evidence`: LabelEvidence of at least one label; -infinity for a label that has no clips.
BestLabel FindBestLabel(const std::vector<double>& evidence, const WindowAlignment& alignment);

// Returns the features of UnknownModel: by how much the log distance is larger than that of the
// label's held-out clips, and the lead. Both are logarithms of ratios of distances, so that motion
// of another body or recording, which is less like all stored motion, changes them little.
std::array<double, UnknownModel::kFeatures> UnknownFeatures(const BestLabel& best,
                                                            double typical_log_distance);

// The probability that a motion is unknown before it is observed, however many labels there are.
inline constexpr double kUnknownShare = 0.08;

struct LabelAnswer {
  std::vector<LabelScore> labels;  // most probable first
  // Probability that the window has none of the labels. With it the probabilities of the labels sum
  // to 1. Absent if the calibration has no UnknownModel: they then sum to 1 alone. Absent without
  // labels, too.
  std::optional<double> unknown_probability;
};

// Returns the probabilities of `labels` (LabelUnits::labels), given the window. Before the
// observation, all have equal probabilities.
LabelAnswer LabelsOrUnknown(const std::vector<std::string>& labels,
                            const WindowAlignment& alignment, const AnswerCalibration& calibration);

}  // namespace motiondb::core
