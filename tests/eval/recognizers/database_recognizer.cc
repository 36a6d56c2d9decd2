#include "tests/eval/recognizers/database_recognizer.h"

#include <algorithm>

#include "core/motion/error.h"
#include "tests/eval/database_model.h"

namespace motiondb::tests {
namespace {

std::vector<DatabaseSetting> DatabaseSettings() {
  return {{"motiondb", "the server's defaults", {}},
          {"motiondb, PAPER",
           "the server's defaults for this method",
           {.method = core::Method::kPaper}}};
}

}  // namespace

absl::Status DatabaseRecognizer::Fit(const ClipSet& training, Extent) {
  labels_ = LabelsOf(training);
  MOTIONDB_ASSIGN_OR_RETURN(model_, BuildEvalModel(set_, training));
  return absl::OkStatus();
}

absl::StatusOr<Recognition> DatabaseRecognizer::Recognize(const core::StateSequence& observation,
                                                          Extent extent) const {
  core::RecognizeOptions options = setting_.options;
  options.whole = extent != Extent::kWindow;
  options.window_seconds = observation.frame_count() / observation.frame_rate_hz;
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<core::RecognizedWindow> windows,
                            core::Recognize(*model_, observation, options));
  const core::RecognizedWindow& window = windows.front();
  Recognition recognition{window.labels.front().label, std::vector<double>(labels_.size()),
                          window.familiarity, window.unknown_probability};
  for (const core::LabelScore& score : window.labels) {
    const auto at = std::lower_bound(labels_.begin(), labels_.end(), score.label);
    recognition.probabilities[at - labels_.begin()] = score.probability;
  }
  return recognition;
}

double DatabaseRecognizer::model_bytes() const { return ModelBytes(*model_); }

std::vector<RecognitionMethod> DatabaseMethods(const core::MarkerSet& set) {
  std::vector<RecognitionMethod> methods;
  for (const DatabaseSetting& setting : DatabaseSettings()) {
    methods.push_back({setting.name, [set, setting] {
                         return std::make_unique<DatabaseRecognizer>(set, setting);
                       }});
  }
  return methods;
}

}  // namespace motiondb::tests
