// What is this motion? (sections IV-B, V-B). Safe to call from any thread; scratch is the call's
// own.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "core/motion/cancellation.h"

namespace motiondb::core {

enum class Generation { kExact, kTopPaths };

struct RecognizeOptions {
  double window_seconds = 0.4;
  bool whole = false;  // one window over the whole observation
  double hop_seconds = 0.1;
  int layer = 0;  // 0 is the bottom layer
  double transition_floor = 1e-6;
  Generation generation = Generation::kExact;
  int path_count = 5;  // with kTopPaths
};

struct ClipScore {
  int clip = 0;                // index into Model::clips()
  double log_probability = 0;  // natural; -infinity where the strict rule allows no path
};

struct LabelScore {
  std::string label;
  double probability = 0;
};

struct RecognizedWindow {
  double start_seconds = 0;
  double end_seconds = 0;
  int layer = 0;
  std::vector<ClipScore> clips;    // most probable first, all of them
  std::vector<LabelScore> labels;  // most probable first; they sum to 1
  double familiarity = 0;
};

// Windows over an observation (not scaled; the model's markers and frame rate). A window of w
// seconds has round(w * rate) frames; an observation shorter than a window is one window.
// INVALID_ARGUMENT for settings out of range (naming the field) or an observation that does not fit
// the model; CANCELLED.
absl::StatusOr<std::vector<RecognizedWindow>> Recognize(const Model& model,
                                                        const StateSequence& observation,
                                                        const RecognizeOptions& options,
                                                        const Cancelled& cancelled = {});

}  // namespace motiondb::core
