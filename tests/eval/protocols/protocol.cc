#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {

const std::vector<Protocol>& Protocols() {
  static const std::vector<Protocol> kProtocols = {
      {"windows", "Windows: database 1, train to test, 0.4 s", RunWindows},
      {"whole", "Whole clips: HDM05, one actor left out", RunWhole},
      {"early", "Early: the beginnings of HDM05's clips", RunEarly},
      {"unknown", "Unknown: motion that is not in the database", RunUnknown},
      {"prediction", "Prediction: 10 frames in, 25 out, at 25 Hz", RunPrediction},
      {"calibration", "Calibration of confidences", RunCalibration},
      {"hard", "Hard conditions", RunHard},
      {"sources", "Sources: the database has another source than the observations", RunSources},
      {"corrupt", "Corrupt frames in stored clips", RunCorrupt},
  };
  return kProtocols;
}

}  // namespace motiondb::tests
