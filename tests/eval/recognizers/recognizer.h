// Interface of recognition methods for the protocols: the database's and the peers'.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/eval/peers/peer.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// The answer "unknown"; no clip has this label.
inline constexpr char kUnknown[] = "unknown";

// Returns whether a method with this probability of unknown motion answers "unknown".
inline bool IsUnknown(std::optional<double> unknown_probability) {
  return unknown_probability.value_or(0) > 0.5;
}

struct Recognition {
  std::string label;                  // the most probable
  std::vector<double> probabilities;  // of Recognizer::labels(); sum to 1 - unknown_probability
  double familiarity = 0;             // higher: more similar to a learned motion
  // Probability that the observation has none of the labels; absent if the method has none.
  std::optional<double> unknown_probability = std::nullopt;

  // Returns the label or kUnknown. "Unknown" is a wrong answer for every motion with a label.
  std::string answer() const { return IsUnknown(unknown_probability) ? kUnknown : label; }
  double answer_probability() const {
    return IsUnknown(unknown_probability) ? *unknown_probability
                                          : *std::ranges::max_element(probabilities);
  }
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
  // Returns a recognizer to fit to other clips with the same parameters, without choosing again.
  virtual std::unique_ptr<Recognizer> WithSameParameters() const = 0;
};

// A named recognition method. Each fold makes its own recognizer.
struct RecognitionMethod {
  std::string name;
  std::function<std::unique_ptr<Recognizer>()> make;
  bool is_peer = false;
};

// Returns the labels of the clips, ascending.
std::vector<std::string> LabelsOf(const ClipSet& clips);

}  // namespace motiondb::tests
