// The protocols: each runs its experiments and says what it found in tables.
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
// The same from their beginnings.
absl::StatusOr<Tables> RunEarly(Studies& studies);
// Telling motion that database 1 knows from motion that it does not.
absl::StatusOr<Tables> RunUnknown(Studies& studies);
// Marker positions up to a second ahead.
absl::StatusOr<Tables> RunPrediction(Studies& studies);
// Whether confidences are what they say.
absl::StatusOr<Tables> RunCalibration(Studies& studies);
// Markers missing or noisy, other frame rates, other formats.
absl::StatusOr<Tables> RunHard(Studies& studies);
// Stored clips with frames that no body can be in.
absl::StatusOr<Tables> RunCorrupt(Studies& studies);

struct Protocol {
  std::string name;
  std::string title;
  absl::StatusOr<Tables> (*run)(Studies&);
};

// In the order in which they are run and printed.
const std::vector<Protocol>& Protocols();

}  // namespace motiondb::tests
