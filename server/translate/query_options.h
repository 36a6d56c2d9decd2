// The settings of a query -> core's options, with defaults for those not given. INVALID_ARGUMENT
// and OUT_OF_RANGE (a layer) name the field. Safe to call from any thread.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/estimation/estimate.h"
#include "core/observe/observer.h"
#include "core/prediction/predict.h"
#include "core/recognition/recognize.h"

namespace motiondb::v1 {
class RecognizeRequest;
class EstimateRequest;
class ObserveStart;
class PredictRequest;
}  // namespace motiondb::v1

namespace motiondb::server {

absl::StatusOr<core::RecognizeOptions> OptionsFrom(const v1::RecognizeRequest& request,
                                                   const core::Model& model);
absl::StatusOr<core::EstimateOptions> OptionsFrom(const v1::EstimateRequest& request,
                                                  const core::Model& model);
// Time between the predictions of a series. At least a frame: in smaller steps it would say the
// same again, without end.
absl::StatusOr<double> StepFrom(std::string_view field, double seconds, const core::Model& model);

// `prefix` leads the names of fields: "" or "prediction.".
absl::StatusOr<core::PredictOptions> OptionsFrom(std::string_view prefix,
                                                 const v1::PredictRequest& request,
                                                 const core::Model& model);

absl::StatusOr<core::ObserverOptions> OptionsFrom(std::string_view prefix,
                                                  const v1::ObserveStart& start,
                                                  const core::Model& model);

}  // namespace motiondb::server
