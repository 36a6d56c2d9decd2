// What is this motion? (sections IV-B, V-B). Safe to call from any thread; scratch is the call's
// own.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/observation.h"
#include "core/motion/cancellation.h"
#include "core/motion/states.h"

namespace motiondb::core {

class Model;

enum class Generation { kExact, kTopPaths };

struct RecognizeOptions {
  Method method = Method::kBest;
  double window_seconds = 0.4;
  // One window over the whole observation, taken for a motion from its beginning on.
  bool whole = false;
  double hop_seconds = 0.1;
  // The rest is for kPaper.
  int layer = 0;  // 0 is the bottom layer
  double transition_floor = 1e-6;
  Generation generation = Generation::kExact;
  int path_count = 5;  // with kTopPaths
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const RecognizeOptions& options);

struct ClipScore {
  int clip = 0;  // index into Model::clips()
  // That the clip generates the window; natural. kPaper: its graph, -infinity where the strict rule
  // allows no path. kBest: its own course of frames, up to a term that all clips of the window
  // share.
  double log_probability = 0;
};

struct LabelScore {
  std::string label;
  double probability = 0;
};

struct RecognizedWindow {
  double start_seconds = 0;
  double end_seconds = 0;
  int layer = 0;
  // Most probable first. kPaper: all clips; kBest: those that were compared frame by frame, which
  // are all of at most 64.
  std::vector<ClipScore> clips;
  std::vector<LabelScore> labels;  // most probable first; they sum to 1
  // Fraction of windows like this one that are less like the stored motion. kPaper: of the stored
  // ones, under the global graph; kBest: of stored ones each compared without its own clip (as
  // kPaper in a model that was not calibrated).
  double familiarity = 0;
};

// By the paper (Method::kPaper) clips and labels are as probable as their graphs generate the
// window; missing markers are left out. Best (Method::kBest): the 64 clips whose nodes the window
// comes nearest (shortlist.h) are compared frame by frame (clip_alignment.h) in the model's metric,
// missing markers filled in; a label is as probable as its best clip, weighted as calibrated. A
// model without a metric answers by the paper.
//
// Windows over an observation (not scaled; the model's markers and frame rate). A window of w
// seconds has round(w * rate) frames; an observation shorter than a window is one window.
// INVALID_ARGUMENT for settings out of range (naming the field) or an observation that does not fit
// the model; CANCELLED.
absl::StatusOr<std::vector<RecognizedWindow>> Recognize(const Model& model,
                                                        const StateSequence& observation,
                                                        const RecognizeOptions& options,
                                                        const Cancelled& cancelled = {});

}  // namespace motiondb::core
