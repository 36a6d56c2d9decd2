// Interface of recognition methods for the protocols: the database's and the peers'.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/eval/peers/peer.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

struct Recognition {
  std::string label;                  // the most probable
  std::vector<double> probabilities;  // of Recognizer::labels(); sum to 1
  double familiarity = 0;             // higher: more similar to a learned motion
};

class Recognizer {
 public:
  virtual ~Recognizer() = default;

  // Learns the clips; chooses parameters for observations of that extent on these clips alone.
  // Called once.
  virtual absl::Status Fit(const ClipSet& training, Extent extent) = 0;

  // The observation is not scaled; NaN is a missing value. Thread-safe after Fit.
  virtual absl::StatusOr<Recognition> Recognize(const core::StateSequence& observation,
                                                Extent extent) const = 0;

  // Ascending.
  virtual const std::vector<std::string>& labels() const = 0;
  // Return how the parameters were chosen, and their values. Call after Fit.
  virtual std::string chosen_by() const = 0;
  virtual std::string parameters() const = 0;
  virtual double model_bytes() const = 0;
};

// A named recognition method. Each fold makes its own recognizer.
struct RecognitionMethod {
  std::string name;
  std::function<std::unique_ptr<Recognizer>()> make;
};

// Returns the labels of the clips, ascending.
std::vector<std::string> LabelsOf(const ClipSet& clips);

}  // namespace motiondb::tests
