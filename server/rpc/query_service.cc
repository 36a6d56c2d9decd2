#include "core/motion/error.h"
#include "core/planning/planner.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "server/engine/prediction_series.h"
#include "server/engine/search_clock.h"
#include "server/rpc/call.h"
#include "server/rpc/query_subject.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
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
  MOTIONDB_ASSIGN_OR_RETURN(const auto prediction,
                            core::Predict(model, states, options, call.cancelled));
  SetPrediction(prediction, subject.database->name(), model, response);
  return absl::OkStatus();
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
  const auto series =
      std::make_shared<PredictionSeries>(subject.snapshot, std::move(states), options, every);
  return [series, name = subject.database->name(),
          cancelled = call.cancelled](v1::PredictSeriesResponse& message) -> absl::StatusOr<bool> {
    MOTIONDB_ASSIGN_OR_RETURN(const auto prediction, series->Next(cancelled));
    if (!prediction.has_value()) return false;
    SetPrediction(*prediction, name, series->model(), *message.mutable_prediction());
    return true;
  };
}

absl::Status Plan(const Call& call, const v1::PlanRequest& request, v1::PlanResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const QuerySubject subject,
                            FindSubject(call.engine, "database", request.database()));
  const core::Model& model = subject.snapshot->model;
  MOTIONDB_ASSIGN_OR_RETURN(
      auto options, OptionsFrom(request, model, call.engine, *subject.database, call.cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, subject.database->scheme());
  MOTIONDB_ASSIGN_OR_RETURN(const PlanBody body, BodyFrom(request, options.start_clip, *scheme,
                                                          call.engine, *subject.database));
  options.problem.skeleton = body.skeleton;
  options.problem.flat_soles = body.is_robot;
  SearchClock clock(options.max_search_seconds, call.deadline);
  const core::PlanControl control{.cancelled = call.cancelled,
                                  .time_up = [&] { return clock.time_up(); },
                                  .search_over = [&] { clock.EndSearch(); }};
  MOTIONDB_ASSIGN_OR_RETURN(const auto answer,
                            core::PlanMotion(model, *scheme, options.problem, control));
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
