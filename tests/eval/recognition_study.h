// The experiments of recognition: folds, fitted methods and their results. Methods are fitted once
// and shared by several protocols.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/eval/progress.h"
#include "tests/eval/recognizers/cross_validation.h"
#include "tests/eval/recognizers/recognizer.h"
#include "tests/eval/statistics/accuracy.h"
#include "tests/support/corpus.h"

namespace motiondb::tests {

// One fold with every method fitted to its training clips.
struct Experiment {
  Fold fold;
  std::vector<std::unique_ptr<Recognizer>> fitted;  // [method]
};

struct ScoredObservation {
  const EvalClip* clip = nullptr;
  Recognition recognition;
};

// The results of one method for all observations, in order of fold, clip and observation.
struct MethodResults {
  std::vector<ScoredObservation> judgements;
  double seconds = 0;  // processor time of all observations

  double milliseconds_each() const;
  // The named label is the answer, which can be kUnknown.
  std::vector<LabelPair> names() const;
  double unknown_fraction() const;  // of the answers; NaN if there are none
};

// Makes observations of a clip.
using Observe = std::function<absl::StatusOr<std::vector<core::StateSequence>>(const EvalClip&)>;

// Returns the clip's states unchanged: whole, or as windows.
Observe Unchanged(Extent extent);

enum class Experiments {
  kDatabase1Windows,  // train -> test, fitted for windows
  kDatabase1Clips,    // train -> test, fitted for whole clips
  kHdm05Clips,        // leave one actor out, fitted for whole clips
};

// Not thread-safe; uses the given threads.
class RecognitionStudy {
 public:
  RecognitionStudy(std::filesystem::path data, double frame_rate_hz, core::ParallelFor parallel,
                   Progress& progress);

  const std::filesystem::path& data() const { return data_; }
  // Reads the corpus on first use.
  absl::StatusOr<const Corpus*> LoadedCorpus();
  const std::vector<RecognitionMethod>& methods() const { return methods_; }

  // Fits on first use.
  absl::StatusOr<const std::vector<Experiment>*> Fitted(Experiments which);

  // Runs every method on the observations of each fold's test clips, or of `clips` if given.
  // Returns one MethodResults per method. `stage` is the label of the progress bar.
  absl::StatusOr<std::vector<MethodResults>> RunMethods(const std::string& stage, Experiments which,
                                                        Extent extent, const Observe& observe,
                                                        const ClipSet* clips = nullptr);

  // Runs bodies on the given threads, with progress.
  void ForEach(const std::string& stage, int count, const std::function<void(int)>& body);

  // Returns how a method's parameters were chosen, over the folds.
  std::string Chosen(Experiments which, std::size_t method) const;
  // Returns the mean over the folds.
  double ModelBytes(Experiments which, std::size_t method) const;

 private:
  const std::filesystem::path data_;
  const double frame_rate_hz_;
  const core::ParallelFor parallel_;
  Progress& progress_;
  std::optional<Corpus> corpus_;
  std::vector<RecognitionMethod> methods_;
  std::map<Experiments, std::vector<Experiment>> experiments_;
};

}  // namespace motiondb::tests
