// Converts query requests to options of core, and results of core to messages.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/observe/observer.h"
#include "core/prediction/predict.h"
#include "core/recognition/find_motion.h"
#include "core/recognition/recognize.h"
#include "server/engine/query/query.h"

namespace motiondb::v1 {
class EstimateRequest;
class EstimateResponse;
class FindRequest;
class FindResponse;
class LabelProbability;
class NodeState;
class ObserveStart;
class PredictRequest;
class PredictResponse;
class PredictSeriesRequest;
class PredictedFrame;
class TrackLabels;
class RecognizeRequest;
class RecognizeResponse;
}  // namespace motiondb::v1

namespace motiondb::server {

// Sets at most `top_count` clips for each window; 0 means all.
void SetRecognition(const std::vector<core::RecognizedWindow>& windows, const std::string& database,
                    const core::Model& model, int top_count, v1::RecognizeResponse& message);

void SetMatches(const std::vector<core::MotionMatch>& matches, const std::string& database,
                const core::Model& model, v1::FindResponse& message);

void SetEstimation(const core::Estimation& estimation, const core::Model& model,
                   v1::EstimateResponse& message);

void SetPrediction(const core::Prediction& prediction, const std::string& database,
                   const core::Model& model, v1::PredictResponse& message);

// Common parts of responses. `top_count`: maximum number of labels; 0 means all.
void SetState(const core::NodeState& state, v1::NodeState& message);
void SetLabels(const std::vector<core::LabelScore>& labels, int top_count,
               google::protobuf::RepeatedPtrField<v1::LabelProbability>& messages);
void SetTracks(const std::vector<core::TrackAnswer>& tracks, int top_count,
               google::protobuf::RepeatedPtrField<v1::TrackLabels>& messages);
void SetHorizons(const std::vector<core::PredictedFrame>& frames,
                 google::protobuf::RepeatedPtrField<v1::PredictedFrame>& messages);

// Convert the settings of a query to options of core, with the defaults of core for settings not
// given. Core checks options; these functions return INVALID_ARGUMENT for values without an
// equivalent in core: an unknown enumerator, and a number below 1 where absence is 0 in core.

absl::StatusOr<core::RecognizeOptions> ParseRecognizeOptions(const v1::RecognizeRequest& request);
core::FindOptions ParseFindOptions(const v1::FindRequest& request);
absl::StatusOr<core::EstimateOptions> ParseEstimateOptions(const v1::EstimateRequest& request);
absl::StatusOr<core::PredictOptions> ParsePredictOptions(const v1::PredictRequest& request);
absl::StatusOr<SeriesOptions> ParseSeriesOptions(const v1::PredictSeriesRequest& request);
absl::StatusOr<core::ObserverOptions> ParseObserverOptions(const v1::ObserveStart& start);

// Returns the motion to find; refers to the request. `database`: id.
absl::StatusOr<SoughtMotion> ParseSoughtMotion(const v1::FindRequest& request,
                                               const std::string& database);

}  // namespace motiondb::server
