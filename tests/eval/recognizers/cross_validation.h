// Tuning on training clips alone: folds and statistics of held-out scores.
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
  bool by_source = false;
};

// Leaves out one source (subject) at a time if all labels still remain; otherwise distributes the
// clips of each label over three folds. The training clips of every fold have all labels with at
// least two clips.
Folds MakeFolds(const ClipSet& clips);

// Leaves out each source in turn, in order of name.
std::vector<Fold> LeaveOneSourceOut(const ClipSet& clips);

// The result of a fold for a held-out motion.
struct HeldOut {
  std::vector<double> scores;  // one per label; -infinity if the fold's training clips lack it
  int truth = 0;
  int clip = 0;  // which motions are of the same clip
};

double HeldOutAccuracy(const std::vector<HeldOut>& held_out);

// Returns exp(score / temperature), normalized over the labels.
std::vector<double> Softmax(const std::vector<double>& scores, double temperature);

// Returns the temperature, from a geometric series 1e-4 to 1e4, with the maximum softmax likelihood
// of the truths.
double BestTemperature(const std::vector<HeldOut>& held_out);

}  // namespace motiondb::tests
