// The recorded motion that the protocols run on: the index, the clip lists and the clips as states,
// read once. Immutable once loaded; safe to share between threads.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/states.h"
#include "core/tree/parallel.h"

namespace motiondb::tests {

struct EvalClip {
  std::string name;    // path in the data folder
  std::string label;   // behaviour, as the list or index that named the clip says
  std::string source;  // who recorded it: "cmu16", "hdm05-bd"
  std::string format;  // extension of the file, without the dot
  // On the corpus's marker set, at the source's frame rate.
  core::MarkerMotion markers;
  // At the corpus's frame rate.
  core::StateSequence states;
};

// Clips that belong to a corpus, which outlives them.
using ClipSet = std::vector<const EvalClip*>;

struct Corpus {
  core::MarkerSet set;
  double frame_rate_hz = 0;
  std::vector<std::unique_ptr<EvalClip>> clips;

  // The standard markers' corpus.
  ClipSet database1_train;
  ClipSet database1_test;
  ClipSet hdm05;  // label: action, source: actor
  ClipSet other;  // the index's label `other`

  // The prediction benchmark's corpus, on its own markers; label: action.
  ClipSet prediction_train;
  ClipSet prediction_test;  // empty where the folder has none
};

// Database 1, HDM05 and the clips labelled `other` on the standard markers. NOT_FOUND or
// INVALID_ARGUMENT names the file that is missing or wrong.
absl::StatusOr<Corpus> LoadRecognitionCorpus(const std::filesystem::path& data,
                                             double frame_rate_hz,
                                             const core::ParallelFor& parallel);

// All clips of the index on the standard markers, in none of the corpus's sets. Errors as above.
absl::StatusOr<Corpus> LoadIndexedCorpus(const std::filesystem::path& data, double frame_rate_hz,
                                         const core::ParallelFor& parallel);

// The clips in prediction/train and, where there is one, prediction/test, at their own frame rate
// (25 Hz), with all their points as markers. Errors as above.
absl::StatusOr<Corpus> LoadPredictionCorpus(const std::filesystem::path& data,
                                            const core::ParallelFor& parallel);

}  // namespace motiondb::tests
