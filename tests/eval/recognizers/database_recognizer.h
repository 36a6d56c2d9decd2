// The database as a recognizer: builds a model and calls core::Recognize.
#pragma once

#include <optional>

#include "core/model/model.h"
#include "core/recognition/recognize.h"
#include "tests/eval/recognizers/recognizer.h"

namespace motiondb::tests {

struct DatabaseSetting {
  std::string name;
  std::string chosen;
  core::RecognizeOptions options;  // the extent sets `whole`
};

class DatabaseRecognizer : public Recognizer {
 public:
  DatabaseRecognizer(core::MarkerSet set, DatabaseSetting setting)
      : set_(std::move(set)), setting_(std::move(setting)) {}

  absl::Status Fit(const ClipSet& training, Extent extent) override;
  absl::StatusOr<Recognition> Recognize(const core::StateSequence& observation,
                                        Extent extent) const override;
  const std::vector<std::string>& labels() const override { return labels_; }
  std::string chosen_by() const override { return setting_.chosen; }
  std::string parameters() const override { return ""; }
  // Includes states, node statistics, graphs and familiarity statistics.
  double model_bytes() const override;
  std::unique_ptr<Recognizer> WithSameParameters() const override {
    return std::make_unique<DatabaseRecognizer>(set_, setting_);
  }

 private:
  const core::MarkerSet set_;
  const DatabaseSetting setting_;
  std::vector<std::string> labels_;
  std::optional<core::Model> model_;
};

// Returns one row per recognition method of the database.
std::vector<RecognitionMethod> DatabaseMethods(const core::MarkerSet& set);

}  // namespace motiondb::tests
