// The protocols: each runs its experiments and returns tables.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tests/eval/prediction_study.h"
#include "tests/eval/recognition_study.h"
#include "tests/eval/table.h"

namespace motiondb::tests {

struct Studies {
  RecognitionStudy recognition;
  PredictionStudy prediction;
};

using Tables = std::vector<Table>;

// 0.4-s windows of database 1's test clips.
absl::StatusOr<Tables> RunWindows(Studies& studies);
// Whole clips of HDM05, leaving one actor out.
absl::StatusOr<Tables> RunWhole(Studies& studies);
// Beginnings of HDM05 clips.
absl::StatusOr<Tables> RunEarly(Studies& studies);
// Separating motion that a database knows from unknown motion.
absl::StatusOr<Tables> RunUnknown(Studies& studies);
// Marker positions up to 1 s ahead.
absl::StatusOr<Tables> RunPrediction(Studies& studies);
// Calibration of confidences.
absl::StatusOr<Tables> RunCalibration(Studies& studies);
// Markers missing or noisy, other frame rates, other formats.
absl::StatusOr<Tables> RunHard(Studies& studies);
// Databases and observations of different sources.
absl::StatusOr<Tables> RunSources(Studies& studies);
// Stored clips with impossible frames.
absl::StatusOr<Tables> RunCorrupt(Studies& studies);

struct Protocol {
  std::string name;
  std::string title;
  absl::StatusOr<Tables> (*run)(Studies&);
};

// Returns the protocols in the order of running and printing.
const std::vector<Protocol>& Protocols();

}  // namespace motiondb::tests
