// Memory that queries take: estimates from above, by the observation, the options and the model,
// before anything is computed. All in bytes; the observation's states are included. Pure; safe to
// call from any thread.
#pragma once

#include <cstdint>

#include "core/estimation/estimate.h"
#include "core/motion/states.h"
#include "core/observe/observer.h"
#include "core/planning/plan.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"

namespace motiondb::server {

// With `top_count` as in RecognizeRequest; the response is included.
std::int64_t BytesToRecognize(const core::Model& model, const core::StateSequence& states,
                              const core::RecognizeOptions& options, int top_count);
// The response is included.
std::int64_t BytesToEstimate(const core::Model& model, const core::StateSequence& states,
                             const core::EstimateOptions& options);
// The response is included, but for the names of clips.
std::int64_t BytesToPredict(const core::Model& model, const core::StateSequence& states,
                            const core::PredictOptions& options);
// Names of clips in the response to a prediction.
std::int64_t BytesOfClipNames(const core::Prediction& prediction);
// Memory of a stream of frames.
struct ObserveMemory {
  std::int64_t kept = 0;    // from its beginning to its end
  std::int64_t answer = 0;  // and while it answers
};
ObserveMemory BytesToObserve(const core::Model& model, const core::ObserverOptions& options);
// Without the response; `problem` with its skeleton.
std::int64_t BytesToPlan(const core::Model& model, const core::PlanProblem& problem);
// The plan and the response with it.
std::int64_t BytesOfPlan(const core::PlanAnswer& answer, bool with_files);

}  // namespace motiondb::server
