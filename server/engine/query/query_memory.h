// Upper bounds of the memory of queries and of their responses, computed before anything is
// allocated, from observation, options and model. All in bytes, with the states of the observation.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/estimation/estimate.h"
#include "core/motion/states.h"
#include "core/observe/observer.h"
#include "core/planning/plan.h"
#include "core/prediction/predict.h"
#include "core/recognition/find_motion.h"
#include "core/recognition/recognize.h"

namespace motiondb::server {

// With the response; `top_count` as in RecognizeRequest.
std::int64_t BytesToRecognize(const core::Model& model, const core::StateSequence& states,
                              const core::RecognizeOptions& options, int top_count);
// INVALID_ARGUMENT naming top_count if the windows have more clips and labels than one response may
// have.
absl::Status CheckScores(const std::vector<core::RecognizedWindow>& windows, int top_count);
// With the response. `frames`: of the whole observation, or of the part of a clip.
std::int64_t BytesToFind(const core::Model& model, int frames, const core::FindOptions& options);
// With the response.
std::int64_t BytesToEstimate(const core::Model& model, const core::StateSequence& states,
                             const core::EstimateOptions& options);
// With the response except clip names.
std::int64_t BytesToPredict(const core::Model& model, const core::StateSequence& states,
                            const core::PredictOptions& options);
// Clip names in the response of a prediction.
std::int64_t BytesOfClipNames(const core::Prediction& prediction);
// Memory of a stream of frames.
struct ObserveMemory {
  std::int64_t kept = 0;    // for the whole stream
  std::int64_t answer = 0;  // in addition, while it computes an answer
};
ObserveMemory BytesToObserve(const core::Model& model, const core::ObserverOptions& options);
// Without the response. `problem` must have its skeleton.
std::int64_t BytesToPlan(const core::Model& model, const core::PlanProblem& problem);
// The plan and its response.
std::int64_t BytesOfPlan(const core::PlanAnswer& answer, bool with_files);

}  // namespace motiondb::server
