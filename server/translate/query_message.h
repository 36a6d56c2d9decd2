// Answers of core as messages. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "core/estimation/estimate.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"

namespace motiondb::v1 {
class RecognizeResponse;
class EstimateResponse;
class PredictResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// `top_count` clips a window; 0 means all.
void SetRecognition(const std::vector<core::RecognizedWindow>& windows, const std::string& database,
                    const core::Model& model, int top_count, v1::RecognizeResponse& message);

void SetEstimation(const core::Estimation& estimation, const core::Model& model,
                   v1::EstimateResponse& message);

void SetPrediction(const core::Prediction& prediction, const std::string& database,
                   const core::Model& model, v1::PredictResponse& message);

}  // namespace motiondb::server
