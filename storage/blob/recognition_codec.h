// What recognition learned, as fields of a model: the metric and the calibration.
#pragma once

#include "core/model/motion_metric.h"
#include "core/model/recognition_calibration.h"
#include "storage/blob/fields.h"

namespace motiondb::storage {

void PutMetric(FieldWriter& writer, const core::MotionMetric& metric);
// Of states of `dimensions` numbers.
core::MotionMetric GetMetric(FieldReader& reader, Eigen::Index dimensions);

void PutRecognition(FieldWriter& writer, const core::RecognitionCalibration& calibration);
core::RecognitionCalibration GetRecognition(FieldReader& reader);

}  // namespace motiondb::storage
