#include <cmath>

#include "core/motion/error.h"
#include "core/planning/planner.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "server/engine/prediction_series.h"
#include "server/engine/query_memory.h"
#include "server/engine/search_clock.h"
#include "server/rpc/call.h"
#include "server/rpc/query_subject.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/field_violation.h"
#include "server/translate/numbers.h"
#include "server/translate/observation.h"
#include "server/translate/plan_body.h"
#include "server/translate/plan_message.h"
#include "server/translate/plan_options.h"
#include "server/translate/query_message.h"
#include "server/translate/query_options.h"

namespace motiondb::server {
namespace {

absl::Status Recognize(const Call& call, const v1::RecognizeRequest& request,
                       v1::RecognizeResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, OptionsFrom(request, model));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states,
                            StatesFrom("observation", request.observation(), call.engine,
                                       *subject.database, call.terms()));
  MOTIONDB_RETURN_IF_ERROR(
      call.terms().Reserve(BytesToRecognize(model, states, options, request.top_count())));
  MOTIONDB_ASSIGN_OR_RETURN(const auto windows,
                            core::Recognize(model, states, options, call.cancelled));
  return SetRecognition(windows, subject.database->name(), model, request.top_count(), response);
}

absl::Status Estimate(const Call& call, const v1::EstimateRequest& request,
                      v1::EstimateResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, OptionsFrom(request, model));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states,
                            StatesFrom("observation", request.observation(), call.engine,
                                       *subject.database, call.terms()));
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(BytesToEstimate(model, states, options)));
  MOTIONDB_ASSIGN_OR_RETURN(const auto estimation,
                            core::Estimate(model, states, options, call.cancelled));
  SetEstimation(estimation, model, response);
  return absl::OkStatus();
}

absl::Status Predict(const Call& call, const v1::PredictRequest& request,
                     v1::PredictResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, OptionsFrom("", request, model));
  MOTIONDB_ASSIGN_OR_RETURN(const auto states,
                            StatesFrom("observation", request.observation(), call.engine,
                                       *subject.database, call.terms()));
  const std::int64_t bytes = BytesToPredict(model, states, options);
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(bytes));
  MOTIONDB_ASSIGN_OR_RETURN(const auto prediction,
                            core::Predict(model, states, options, call.cancelled));
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(bytes + BytesOfClipNames(prediction)));
  SetPrediction(prediction, subject.database->name(), model, response);
  return absl::OkStatus();
}

// A series is a long call: it gives way to other clients after each moment, and is bounded as a
// whole.
absl::Status CheckSeries(const core::StateSequence& states, const core::PredictOptions& options,
                         double every_seconds) {
  constexpr double kMostPredictions = 1 << 18;
  const double moments = 1 + states.frame_count() / states.frame_rate_hz / every_seconds;
  const double predictions = moments * static_cast<double>(options.horizon_seconds.size());
  if (predictions <= kMostPredictions) return absl::OkStatus();
  return FieldViolation("every_seconds",
                        "{:.0f} moments of {} horizons each; expected at most {:.0f} predictions "
                        "in all: ask for fewer horizons, longer steps or a shorter observation",
                        std::floor(moments), options.horizon_seconds.size(), kMostPredictions);
}

absl::StatusOr<NextMessage<v1::PredictSeriesResponse>> OpenSeries(
    const Call& call, const v1::PredictSeriesRequest& request) {
  const v1::PredictRequest& first = request.prediction();
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "prediction.database", first.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, OptionsFrom("prediction.", first, model));
  MOTIONDB_ASSIGN_OR_RETURN(const double every,
                            StepFrom("every_seconds", request.every_seconds(), model));
  MOTIONDB_ASSIGN_OR_RETURN(auto states, StatesFrom("prediction.observation", first.observation(),
                                                    call.engine, *subject.database, call.terms()));
  MOTIONDB_RETURN_IF_ERROR(CheckSeries(states, options, every));
  const std::int64_t bytes = BytesToPredict(model, states, options);
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(bytes));
  const auto series =
      std::make_shared<PredictionSeries>(subject.snapshot, std::move(states), options, every);
  return [series, name = subject.database->name(), bytes,
          terms = call.terms()](v1::PredictSeriesResponse& message) -> absl::StatusOr<bool> {
    MOTIONDB_ASSIGN_OR_RETURN(const auto prediction, series->Next(terms.cancelled));
    if (!prediction.has_value()) return false;
    MOTIONDB_RETURN_IF_ERROR(terms.Reserve(bytes + BytesOfClipNames(*prediction)));
    SetPrediction(*prediction, name, series->model(), *message.mutable_prediction());
    return true;
  };
}

absl::Status Plan(const Call& call, const v1::PlanRequest& request, v1::PlanResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(
      auto options, OptionsFrom(request, model, call.engine, *subject.database, call.terms()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, subject.database->scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const PlanBody body, BodyFrom(request, options.start_clip, *scheme,
                                                          call.engine, *subject.database));
  options.problem.skeleton = body.skeleton;
  options.problem.flat_soles = body.is_robot;
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(BytesToPlan(model, options.problem)));
  SearchClock clock(options.max_search_seconds, call.deadline);
  const core::PlanControl control{.cancelled = call.cancelled,
                                  .time_up = [&] { return clock.time_up(); },
                                  .search_over = [&] { clock.EndSearch(); }};
  MOTIONDB_ASSIGN_OR_RETURN(const auto answer,
                            core::PlanMotion(model, *scheme, options.problem, control));
  MOTIONDB_RETURN_IF_ERROR(call.terms().Reserve(BytesOfPlan(answer, request.include_files())));
  MOTIONDB_RETURN_IF_ERROR(SetPlan(answer, subject.database->name(), model, body,
                                   request.include_files(), call.cancelled, response));
  response.mutable_effort()->set_search_seconds(clock.search_seconds());
  response.mutable_effort()->set_total_seconds(clock.total_seconds());
  return absl::OkStatus();
}

class QueryServiceImpl final : public v1::QueryService::CallbackService {
 public:
  explicit QueryServiceImpl(CallHost& host) : host_(host) {}

  grpc::ServerUnaryReactor* Recognize(grpc::CallbackServerContext* context,
                                      const v1::RecognizeRequest* request,
                                      v1::RecognizeResponse* response) override {
    return Answer<server::Recognize>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* Estimate(grpc::CallbackServerContext* context,
                                     const v1::EstimateRequest* request,
                                     v1::EstimateResponse* response) override {
    return Answer<server::Estimate>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* Predict(grpc::CallbackServerContext* context,
                                    const v1::PredictRequest* request,
                                    v1::PredictResponse* response) override {
    return Answer<server::Predict>(host_, context, request, response);
  }
  grpc::ServerWriteReactor<v1::PredictSeriesResponse>* PredictSeries(
      grpc::CallbackServerContext* context, const v1::PredictSeriesRequest* request) override {
    return new StreamReactor<v1::PredictSeriesRequest, v1::PredictSeriesResponse>(
        host_, context, request, OpenSeries);
  }
  grpc::ServerUnaryReactor* Plan(grpc::CallbackServerContext* context,
                                 const v1::PlanRequest* request,
                                 v1::PlanResponse* response) override {
    return Answer<server::Plan>(host_, context, request, response);
  }

 private:
  CallHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeQueryService(CallHost& host) {
  return std::make_unique<QueryServiceImpl>(host);
}

}  // namespace motiondb::server
