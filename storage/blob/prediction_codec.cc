#include "storage/blob/prediction_codec.h"

#include <cmath>

#include "storage/blob/matrix_fields.h"

namespace motiondb::storage {
namespace {

constexpr std::size_t kLawBytes = 12 * sizeof(double);

}  // namespace

void PutPrior(FieldWriter& writer, const core::MotionPrior& prior) {
  writer.PutArray(prior.seconds);
  PutMatrix(writer, prior.weights);
}

core::MotionPrior GetPrior(FieldReader& reader, Eigen::Index dimensions) {
  core::MotionPrior prior;
  prior.seconds = reader.GetArray<double>();
  for (std::size_t i = 0; i < prior.seconds.size(); ++i) {
    if (!(prior.seconds[i] > (i == 0 ? 0 : prior.seconds[i - 1]))) {
      reader.Fail(core::DataLoss("motion prior: its horizons do not ascend"));
      return {};
    }
  }
  const auto horizons = static_cast<Eigen::Index>(prior.seconds.size());
  const Eigen::Index numbers = dimensions / 2;
  GetMatrix(reader, horizons == 0 ? 0 : (1 + core::kLags) * numbers, horizons * numbers,
            prior.weights);
  return prior;
}

void PutConfidence(FieldWriter& writer, const core::PredictionConfidence& confidence) {
  writer.PutCount(confidence.laws.size());
  for (const core::ErrorLaw& law : confidence.laws) {
    writer.Put(law.seconds);
    for (const double coefficient : law.coefficients) writer.Put(coefficient);
    for (const double lowest : law.lowest) writer.Put(lowest);
    for (const double highest : law.highest) writer.Put(highest);
    writer.Put(law.deviation);
  }
}

core::PredictionConfidence GetConfidence(FieldReader& reader) {
  core::PredictionConfidence confidence;
  confidence.laws.resize(reader.GetCount(kLawBytes));
  double before = 0;
  for (core::ErrorLaw& law : confidence.laws) {
    law.seconds = reader.Get<double>();
    bool finite = law.seconds > before && std::isfinite(law.seconds);
    before = law.seconds;
    const auto get = [&](auto& numbers) {
      for (double& number : numbers) {
        number = reader.Get<double>();
        finite = finite && std::isfinite(number);
      }
    };
    get(law.coefficients);
    get(law.lowest);
    get(law.highest);
    law.deviation = reader.Get<double>();
    for (std::size_t i = 0; i < law.lowest.size(); ++i) {
      finite = finite && law.lowest[i] <= law.highest[i];
    }
    if (!finite || !(law.deviation > 0)) {
      reader.Fail(core::DataLoss("confidence: a law of prediction errors is none"));
      return {};
    }
  }
  return confidence;
}

}  // namespace motiondb::storage
