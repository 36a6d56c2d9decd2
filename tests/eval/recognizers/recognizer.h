// What the protocols of recognition ask: a way to name a motion, the database's or a peer's.
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
  std::vector<double> probabilities;  // of Recognizer::labels(), they sum to 1
  double familiarity = 0;             // the higher, the more like something learned
};

class Recognizer {
 public:
  virtual ~Recognizer() = default;

  // Learns the clips, with parameters chosen for observations of that extent from these clips
  // alone. Once.
  virtual absl::Status Fit(const ClipSet& training, Extent extent) = 0;

  // The observation is not scaled; NaN is a missing number. Safe to call from any thread once
  // fitted.
  virtual absl::StatusOr<Recognition> Recognize(const core::StateSequence& observation,
                                                Extent extent) const = 0;

  // Ascending.
  virtual const std::vector<std::string>& labels() const = 0;
  // How the parameters were chosen, and which they are. Once fitted.
  virtual std::string chosen_by() const = 0;
  virtual std::string parameters() const = 0;
  virtual double model_bytes() const = 0;
};

// A way to recognize, by name: each fold makes its own recognizer.
struct RecognitionMethod {
  std::string name;
  std::function<std::unique_ptr<Recognizer>()> make;
};

// The labels of clips, ascending.
std::vector<std::string> LabelsOf(const ClipSet& clips);

}  // namespace motiondb::tests
