// What a model has learned of how motion goes on <-> fields. Damage is DATA_LOSS in the reader.
#pragma once

#include "core/model/motion_prior.h"
#include "core/model/prediction_confidence.h"
#include "storage/blob/fields.h"

namespace motiondb::storage {

void PutPrior(FieldWriter& writer, const core::MotionPrior& prior);
// `dimensions`: of a state.
core::MotionPrior GetPrior(FieldReader& reader, Eigen::Index dimensions);

void PutConfidence(FieldWriter& writer, const core::PredictionConfidence& confidence);
core::PredictionConfidence GetConfidence(FieldReader& reader);

}  // namespace motiondb::storage
