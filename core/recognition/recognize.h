// Recognizes the behaviour of a motion (sections IV-B, V-B).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/inference/observation.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::core {

class ClipMask;
class Model;

enum class Generation { kExact, kTopPaths };

struct RecognizeOptions {
  Method method = Method::kBest;
  double window_seconds = 0.4;
  // One window over the whole observation, which is compared with stored clips from their start.
  bool whole = false;
  double hop_seconds = 0.1;
  // Of the graph: for kPaper, and for familiarity if the model is not calibrated.
  int layer = 0;  // 0: the bottom layer
  // For kPaper only:
  double transition_floor = 1e-6;
  Generation generation = Generation::kExact;
  int path_count = 5;  // of kTopPaths
  // Of the labels; empty: kActionTrack. On a track without labels the answer has none.
  std::string track = {};
  // Clips to use (core/model/clip_mask.h), made for the model; null: all.
  std::shared_ptr<const ClipMask> mask = nullptr;
};

// INVALID_ARGUMENT naming the field if an option is out of range.
absl::Status CheckOptions(const RecognizeOptions& options);

struct ClipScore {
  int clip = 0;  // index into Model::clips()
  // Natural logarithm of the probability that the part of the clip with one label that matches best
  // generates the window. kPaper: by its graph; -infinity if transition_floor is 0 and no path
  // exists. kBest: by its sequence of frames, up to a constant that is the same for all clips of
  // the window.
  double log_probability = 0;
  // Of the clip's part that matches best (label_units.h), whose log probability this is; empty if
  // it has none.
  std::string label;
};

struct LabelScore {
  std::string label;
  double probability = 0;
};

// The labels of another track, from the parts of clips that match the window: the probability that
// a matching frame has the label there.
struct TrackAnswer {
  std::string track;
  std::vector<LabelScore> labels;  // most probable first
  double none = 1;                 // no label there, or unknown motion; all sum to 1
};

struct RecognizedWindow {
  double start_seconds = 0;
  double end_seconds = 0;
  int layer = 0;
  // Most probable first. kPaper: all used clips; kBest: the shortlisted clips, at most 64.
  std::vector<ClipScore> clips;
  std::vector<LabelScore> labels;  // of the track asked for, most probable first
  // Probability that the window has none of the labels (unknown.h): with it the probabilities of
  // the labels sum to 1. Absent for kPaper and for models that cannot be calibrated for it
  // (UnknownCalibration): the labels sum to 1 alone.
  std::optional<double> unknown_probability;
  // Fraction of reference windows that are less similar to the stored motion than this window.
  // kPaper: stored windows, under the global graph. kBest: stored windows, each compared without
  // its own clip (as kPaper if the model is not calibrated).
  double familiarity = 0;
  std::vector<TrackAnswer> other_tracks;  // ascending by track; those of the used clips
};

// The windows of an observation, and how they are recognized.
struct WindowPlan {
  int width = 0;  // frames
  int hop = 0;    // frames
  int count = 0;
  bool is_aligned = false;  // compared with clips; otherwise by the graph alone
  bool uses_graph = false;
};

// REQUIRES: CheckOptions returned OK.
WindowPlan PlanWindows(const Model& model, const StateSequence& observation,
                       const RecognizeOptions& options);

// Recognizes the windows of an observation (not scaled; the model's markers and frame rate). A
// window of w seconds has round(w * rate) frames; an observation shorter than a window is one
// window.
//
// Method::kPaper: probabilities of clips and labels are generation probabilities; missing markers
// are ignored. Method::kBest: the 64 clips with nodes nearest to the window (shortlist.h) are
// compared frame by frame (clip_alignment.h) in the model's metric, with missing markers filled in.
// A clip is compared in parts that have one label, or none, on the track (label_units.h). A label
// has the evidence of its best part, with the weight that is calibrated on kActionTrack. A model
// without a metric uses kPaper.
//
// INVALID_ARGUMENT if an option is out of range (naming the field) or the observation does not fit
// the model; CANCELLED.
absl::StatusOr<std::vector<RecognizedWindow>> Recognize(const Model& model,
                                                        const StateSequence& observation,
                                                        const RecognizeOptions& options,
                                                        const Cancelled& cancelled = {});

}  // namespace motiondb::core
