// The recorded motion of the evaluation protocols: index, clip lists, and the clips as states.
// Immutable once loaded.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/states.h"

namespace motiondb::tests {

struct EvalClip {
  std::string name;    // path in the data folder
  std::string label;   // behaviour, from the list or index that names the clip
  std::string source;  // who was recorded: "cmu16", "hdm05-bd"
  std::string format;  // extension of the file, without the dot
  // On the corpus's marker set, at the source's frame rate.
  core::MarkerMotion markers;
  // At the corpus's frame rate.
  core::StateSequence states;
};

// Clips owned by a corpus, which must outlive them.
using ClipSet = std::vector<const EvalClip*>;

struct Corpus {
  core::MarkerSet set;
  double frame_rate_hz = 0;
  std::vector<std::unique_ptr<EvalClip>> clips;

  // On the standard markers.
  ClipSet database1_train;
  ClipSet database1_test;
  ClipSet hdm05;  // label: action, source: actor
  ClipSet other;  // the index's label `other`

  // Of the prediction benchmark, on its own markers; label: action.
  ClipSet prediction_train;
  ClipSet prediction_test;  // empty if the folder has none
};

// Loads database 1, HDM05 and the clips labelled `other` on the standard markers. NOT_FOUND or
// INVALID_ARGUMENT names the missing or invalid file.
absl::StatusOr<Corpus> LoadRecognitionCorpus(const std::filesystem::path& data,
                                             double frame_rate_hz,
                                             const core::ParallelFor& parallel);

// Loads all clips of the index on the standard markers, in no clip set. Errors as above.
absl::StatusOr<Corpus> LoadIndexedCorpus(const std::filesystem::path& data, double frame_rate_hz,
                                         const core::ParallelFor& parallel);

// Loads prediction/train and, if present, prediction/test at their own frame rate (25 Hz). All
// points are markers. Errors as above.
absl::StatusOr<Corpus> LoadPredictionCorpus(const std::filesystem::path& data,
                                            const core::ParallelFor& parallel);

}  // namespace motiondb::tests
