// Fits the calibration of recognition to held-out observations: the weight of the evidence, which
// calibrates label probabilities, and the probability that a motion is unknown
// (core/recognition/unknown.h).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/model/answer_calibration.h"
#include "core/recognition/unknown.h"

namespace motiondb::core {

// A held-out observation, for FitEvidenceWeight.
struct JudgedSample {
  std::vector<double> evidence;  // log probability of each label, up to a constant
  std::size_t label = 0;         // index of the correct label
  int frames = 0;                // number of frames that the evidence sums over
};

// Returns the mean of -log p over the samples. p: probability of the correct label,
// softmax(weight.At(frames) * evidence)[label].
double NegativeLogLikelihood(const std::vector<JudgedSample>& samples,
                             const EvidenceWeight& weight);

// Returns the weight with the minimum NegativeLogLikelihood. Searches scales from exp(-6) to exp(2)
// and all `powers`. REQUIRES: `samples` is not empty.
EvidenceWeight FitEvidenceWeight(const std::vector<JudgedSample>& samples,
                                 const std::vector<double>& powers);

// Kind of a row of features, for FitUnknownRegression: the clip of a held-out observation, which is
// unknown if the clip's label was held out, too.
struct HeldOutKind {
  bool is_unknown = false;
  int clip = 0;
  std::size_t label = 0;
};

// Logistic regression that separates unknown from known held-out motion, for any features:
// P(unknown) = 1 / (1 + exp(-(intercept + weights x))).
struct UnknownRegression {
  double intercept = 0;
  Eigen::VectorXd weights;
};

// Fits the regression to `features` (samples x features, finite), a row for each of `kinds`.
// nullopt unless there are at least 4 known and 4 unknown clips, each of at least two labels.
//
// Labels count equally; unknown samples have the share kUnknownShare of all weight. The ridge is
// 0.1 over the number of clips, on standardized features. `signs`: the sign that a feature's weight
// has by its meaning, 1 or -1; 0 leaves the feature out. A weight with another sign is 0. Newton's
// method; O(samples * features^2) for each step.
std::optional<UnknownRegression> FitUnknownRegression(const std::vector<HeldOutKind>& kinds,
                                                      const Eigen::MatrixXd& features,
                                                      std::vector<int> signs);

// A held-out observation, for FitUnknownModel: known if the model kept other clips of its label,
// unknown if it was aligned without all clips of its label and of its subject.
struct UnknownSample {
  bool is_unknown = false;
  int clip = 0;
  std::size_t label = 0;  // of the clip, an index into the labels
  BestLabel best;
  double own_log_distance = 0;  // known: LogDistance of its own label
};

// Fits the model by FitUnknownRegression; nullopt as there.
//
// The log distance of a label is the mean of its known clips, shrunk towards that of all labels as
// by 4 more clips; a sample is compared with it without its own clip. The lead is not used if
// unknown samples can have only one label.
std::optional<UnknownModel> FitUnknownModel(const std::vector<std::string>& labels,
                                            const std::vector<UnknownSample>& samples);

}  // namespace motiondb::core
