// The probability that a motion is unknown: that it has none of the stored labels.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/model/recognition_calibration.h"
#include "core/recognition/recognize.h"
#include "core/recognition/window_alignment.h"

namespace motiondb::core {

// What an alignment says about the most probable label.
struct BestLabel {
  std::size_t label = 0;  // index into the labels
  double fit = 0;         // FitWithoutNoise
  // Natural logarithm of the fit of the second-best label over `fit`: how many times more the
  // motion differs from it. At least 0; 0 without a second label.
  double lead = 0;
};

// Returns the log evidence per frame that a label's evidence would be without noise of the
// observation. Noise adds the same amount to the squared distances from all motion.
double FitWithoutNoise(double evidence, const WindowAlignment& alignment);

// `evidence`: LabelEvidence of at least one label; -infinity for a label that has no clips.
BestLabel FindBestLabel(const std::vector<double>& evidence, const WindowAlignment& alignment);

// Returns the features of UnknownModel: the deviation of the fit from that of the label's held-out
// clips, in standard deviations, where x is replaced by x / (1 + |x| / 6) because it is unbounded;
// and the lead. Both compare with stored motion of the same label or with another label, so that a
// body or a recording unlike the stored ones changes them little.
std::array<double, UnknownModel::kFeatures> UnknownFeatures(const BestLabel& best, double mean,
                                                            double deviation);

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
