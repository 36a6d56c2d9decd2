#include "storage/blob/recognition_codec.h"

#include <cmath>

#include "storage/blob/matrix_fields.h"

namespace motiondb::storage {
namespace {

void PutAnswer(FieldWriter& writer, const core::AnswerCalibration& calibration) {
  writer.Put(calibration.weight.scale);
  writer.Put(calibration.weight.power);
  writer.PutArray(calibration.familiarity);
}

core::AnswerCalibration GetAnswer(FieldReader& reader) {
  core::AnswerCalibration calibration;
  calibration.weight.scale = reader.Get<double>();
  calibration.weight.power = reader.Get<double>();
  calibration.familiarity = reader.GetArray<float>();
  const auto& [scale, power] = calibration.weight;
  if (!(scale > 0 && std::isfinite(scale) && power >= 0 && power <= 1)) {
    reader.Fail(core::DataLoss("calibration: evidence is weighted {}, power {}", scale, power));
  }
  for (std::size_t i = 0; i < calibration.familiarity.size(); ++i) {
    const float score = calibration.familiarity[i];
    if (std::isnan(score) || (i > 0 && score < calibration.familiarity[i - 1])) {
      reader.Fail(core::DataLoss("calibration: its familiarity scores do not ascend"));
      break;
    }
  }
  return calibration;
}

}  // namespace

void PutMetric(FieldWriter& writer, const core::MotionMetric& metric) {
  writer.PutCount(static_cast<std::size_t>(metric.projection.cols()));
  if (metric.empty()) return;
  writer.PutCount(static_cast<std::size_t>(metric.loadings.cols()));
  PutMatrix(writer, metric.mean);
  PutMatrix(writer, metric.loadings);
  writer.Put(metric.noise);
  PutMatrix(writer, metric.whitening);
  PutMatrix(writer, metric.projection);
}

core::MotionMetric GetMetric(FieldReader& reader, Eigen::Index dimensions) {
  core::MotionMetric metric;
  const auto directions = reader.Get<std::uint32_t>();
  if (directions == 0) return metric;
  if (dimensions == 0) {
    reader.Fail(core::DataLoss("metric: {} directions among no dimensions", directions));
    return metric;
  }
  const auto loadings = reader.Get<std::uint32_t>();
  GetMatrix(reader, 1, dimensions, metric.mean);
  GetMatrix(reader, dimensions, loadings, metric.loadings);
  metric.noise = reader.Get<double>();
  GetMatrix(reader, dimensions, dimensions, metric.whitening);
  GetMatrix(reader, dimensions, directions, metric.projection);
  return metric;
}

void PutRecognition(FieldWriter& writer, const core::RecognitionCalibration& calibration) {
  PutAnswer(writer, calibration.window);
  PutAnswer(writer, calibration.whole);
}

core::RecognitionCalibration GetRecognition(FieldReader& reader) {
  core::RecognitionCalibration calibration;
  calibration.window = GetAnswer(reader);
  calibration.whole = GetAnswer(reader);
  return calibration;
}

}  // namespace motiondb::storage
