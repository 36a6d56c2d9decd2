#include "tests/eval/statistics/calibration.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/motion/error.h"
#include "tests/eval/protocols/protocol.h"

namespace motiondb::tests {
namespace {

std::vector<Claim> ClaimsOf(const MethodResults& judged) {
  std::vector<Claim> claims;
  for (const ScoredObservation& judgement : judged.judgements) {
    claims.push_back({judgement.recognition.answer_probability(),
                      judgement.clip->label == judgement.recognition.answer()});
  }
  return claims;
}

// Omits empty bins.
Table ReliabilityTable(const std::string& title, const std::vector<Claim>& claims) {
  Table table{.title = title, .columns = {{"cases", 0}, {"mean confidence, %"}, {"correct, %"}}};
  for (const ReliabilityBin& bin : Reliability(claims)) {
    if (bin.count == 0) continue;
    table.rows.push_back(
        {fmt::format("{:.1f} to {:.1f}", bin.lower, bin.upper),
         {static_cast<double>(bin.count), 100 * bin.confidence, 100 * bin.accuracy}});
  }
  return table;
}

absl::Status AddRecognition(RecognitionStudy& study, Tables& tables) {
  struct Part {
    Experiments which;
    Extent extent;
    const char* name;
  };
  Table errors{.title = "Expected calibration error of label probabilities (10 bins)"};
  Tables reliability;
  for (const RecognitionMethod& method : study.methods()) errors.rows.push_back({method.name});
  for (const Part& part :
       {Part{Experiments::kDatabase1Windows, Extent::kWindow, "windows, database 1"},
        Part{Experiments::kDatabase1Clips, Extent::kWhole, "whole clips, database 1"},
        Part{Experiments::kHdm05Clips, Extent::kWhole, "whole clips, HDM05"}}) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodResults> judged,
                              study.RunMethods(fmt::format("calibration, {}", part.name),
                                               part.which, part.extent, Unchanged(part.extent)));
    errors.columns.push_back({part.name, 3});
    for (std::size_t m = 0; m < judged.size(); ++m) {
      const std::vector<Claim> claims = ClaimsOf(judged[m]);
      errors.rows[m].figures.push_back(CalibrationError(Reliability(claims)));
      std::string& chosen = errors.rows[m].chosen;
      chosen += fmt::format("{}for {}: {}", chosen.empty() ? "" : "; ", part.name,
                            study.Chosen(part.which, m));
      reliability.push_back(ReliabilityTable(
          fmt::format("Reliability: {}, {}", study.methods()[m].name, part.name), claims));
    }
  }
  errors.notes.push_back(
      "The confidence is the probability of the answer: of the most probable label, or of unknown "
      "motion if that is above 0.5, which is always wrong here. A peer's label probabilities are "
      "the softmax of its scores, with a temperature chosen on held-out training clips.");
  tables.push_back(std::move(errors));
  std::move(reliability.begin(), reliability.end(), std::back_inserter(tables));
  return absl::OkStatus();
}

absl::Status AddPrediction(PredictionStudy& study, Tables& tables) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<MethodForecasts>* const methods, study.LeaveOneOut());
  Table errors{.title = "Expected calibration error of prediction confidence (10 bins)"};
  for (const double seconds : kHorizonSeconds) {
    errors.columns.push_back({fmt::format("{:.0f} ms", 1000 * seconds), 3});
  }
  errors.columns.push_back({"all", 3});
  Tables reliability;
  for (const MethodForecasts& method : *methods) {
    if (!method.has_confidence()) continue;
    Row& row = errors.rows.emplace_back(Row{method.name, {}, method.chosen});
    std::vector<Claim> all;
    for (std::size_t h = 0; h < kHorizonSeconds.size(); ++h) {
      std::vector<Claim> claims;
      for (const ScoredForecast& forecast : method.forecasts) {
        claims.push_back({forecast.confidence[h], forecast.error_mm[h] <= kCorrectMm});
      }
      row.figures.push_back(CalibrationError(Reliability(claims)));
      all.insert(all.end(), claims.begin(), claims.end());
    }
    row.figures.push_back(CalibrationError(Reliability(all)));
    reliability.push_back(
        ReliabilityTable(fmt::format("Reliability: {}, prediction", method.name), all));
  }
  errors.notes.push_back(
      fmt::format("A prediction is correct if the mean error of its markers is at most {:.0f} mm.",
                  kCorrectMm));
  tables.push_back(std::move(errors));
  std::move(reliability.begin(), reliability.end(), std::back_inserter(tables));
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Tables> RunCalibration(Studies& studies) {
  Tables tables;
  MOTIONDB_RETURN_IF_ERROR(AddRecognition(studies.recognition, tables));
  MOTIONDB_RETURN_IF_ERROR(AddPrediction(studies.prediction, tables));
  return tables;
}

}  // namespace motiondb::tests
