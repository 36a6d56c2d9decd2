// Choosing on training clips alone: folds, and what held-out scores tell.
#pragma once

#include <string>
#include <vector>

#include "tests/support/corpus.h"

namespace motiondb::tests {

struct Fold {
  ClipSet training;
  ClipSet test;
};

struct Folds {
  std::string description;
  std::vector<Fold> folds;
};

// Leaves one source (subject) out where each source's clips leave every label behind; otherwise
// deals the clips of each label out to three folds in turn. Every fold's training has all labels
// that have two clips.
Folds MakeFolds(const ClipSet& clips);

// Leaves out one source after the other, in order of name.
std::vector<Fold> LeaveOneSourceOut(const ClipSet& clips);

// What a fold said of a motion that it did not learn.
struct HeldOut {
  std::vector<double> scores;  // one a label
  int truth = 0;
};

double HeldOutAccuracy(const std::vector<HeldOut>& held_out);

// exp(score / temperature), divided by its sum over the labels.
std::vector<double> Softmax(const std::vector<double>& scores, double temperature);

// The temperature, of a geometric series from 1e-4 to 1e4, at which the softmax gives the truths
// the greatest likelihood.
double BestTemperature(const std::vector<HeldOut>& held_out);

}  // namespace motiondb::tests
