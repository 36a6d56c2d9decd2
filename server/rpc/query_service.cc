#include <memory>

#include "core/motion/error.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "server/engine/query/plan_query.h"
#include "server/rpc/call.h"
#include "server/rpc/services.h"
#include "server/rpc/stream_reactor.h"
#include "server/translate/observation_message.h"
#include "server/translate/plan_message.h"
#include "server/translate/query_message.h"
#include "server/translate/record_messages.h"

namespace motiondb::server {
namespace {

// Sets which model answers, and the revision that it contains.
template <typename Response>
void SetModelOf(const Query& query, Response& response) {
  response.set_revision(query.revision());
  response.set_model_version(query.snapshot()->record.version);
}

absl::Status Recognize(const Call& call, const v1::RecognizeRequest& request,
                       v1::RecognizeResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, BeginQuery(call, request));
  const std::string& database = query.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, ParseRecognizeOptions(request));
  MOTIONDB_ASSIGN_OR_RETURN(const auto observation,
                            ParseObservation("observation", request.observation(), database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto windows,
                            query.Recognize(observation, options, request.top_count()));
  response.set_calibration(CalibrationOf(*query.snapshot()));
  SetModelOf(query, response);
  SetRecognition(windows, database, query.model(), request.top_count(), response);
  return absl::OkStatus();
}

absl::Status Estimate(const Call& call, const v1::EstimateRequest& request,
                      v1::EstimateResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, BeginQuery(call, request));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto observation,
      ParseObservation("observation", request.observation(), query.database()->name()));
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, ParseEstimateOptions(request));
  MOTIONDB_ASSIGN_OR_RETURN(const auto estimation, query.Estimate(observation, options));
  SetEstimation(estimation, query.model(), response);
  SetModelOf(query, response);
  return absl::OkStatus();
}

absl::Status Predict(const Call& call, const v1::PredictRequest& request,
                     v1::PredictResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, BeginQuery(call, request));
  const std::string& database = query.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, ParsePredictOptions(request));
  MOTIONDB_ASSIGN_OR_RETURN(const auto observation,
                            ParseObservation("observation", request.observation(), database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto prediction, query.Predict(observation, options));
  SetPrediction(prediction, database, query.model(), response);
  response.set_calibration(CalibrationOf(*query.snapshot()));
  SetModelOf(query, response);
  return absl::OkStatus();
}

absl::StatusOr<MessageSource<v1::PredictSeriesResponse>> OpenSeries(
    const Call& call, const v1::PredictSeriesRequest& request) {
  const v1::PredictRequest& first = request.prediction();
  const auto begun = BeginQuery(call, first);
  if (!begun.ok()) return core::Within("prediction", begun.status());
  const Query& query = *begun;
  const std::string& database = query.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const auto options, ParseSeriesOptions(request));
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto observation,
      ParseObservation("prediction.observation", first.observation(), database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto series, query.PredictSeries(observation, options));
  return [series, query](v1::PredictSeriesResponse& message) -> absl::StatusOr<bool> {
    MOTIONDB_ASSIGN_OR_RETURN(const auto prediction, series->Next());
    if (!prediction.has_value()) return false;
    v1::PredictResponse& to = *message.mutable_prediction();
    SetPrediction(*prediction, query.database()->name(), query.model(), to);
    to.set_calibration(CalibrationOf(*query.snapshot()));
    SetModelOf(query, to);
    return true;
  };
}

absl::Status Find(const Call& call, const v1::FindRequest& request, v1::FindResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, BeginQuery(call, request));
  const std::string& database = query.database()->name();
  const core::FindOptions options = ParseFindOptions(request);
  MOTIONDB_ASSIGN_OR_RETURN(const SoughtMotion motion, ParseSoughtMotion(request, database));
  MOTIONDB_ASSIGN_OR_RETURN(const auto matches, query.Find(motion, options));
  SetMatches(matches, database, query.model(), response);
  SetModelOf(query, response);
  return absl::OkStatus();
}

absl::Status Plan(const Call& call, const v1::PlanRequest& request, v1::PlanResponse& response) {
  MOTIONDB_ASSIGN_OR_RETURN(const Query query, BeginQuery(call, request));
  const std::string& database = query.database()->name();
  MOTIONDB_ASSIGN_OR_RETURN(const PlanRequest plan, ParsePlanRequest(request, database));
  MOTIONDB_ASSIGN_OR_RETURN(PlanResult result, FindPlan(query, plan));
  SetPlan(std::move(result), database, query.model(), response);
  SetModelOf(query, response);
  return absl::OkStatus();
}

class QueryServiceImpl final : public v1::QueryService::CallbackService {
 public:
  explicit QueryServiceImpl(ServiceContext& host) : host_(host) {}

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
  grpc::ServerUnaryReactor* Find(grpc::CallbackServerContext* context,
                                 const v1::FindRequest* request,
                                 v1::FindResponse* response) override {
    return Answer<server::Find>(host_, context, request, response);
  }
  grpc::ServerUnaryReactor* Plan(grpc::CallbackServerContext* context,
                                 const v1::PlanRequest* request,
                                 v1::PlanResponse* response) override {
    return Answer<server::Plan>(host_, context, request, response);
  }

 private:
  ServiceContext& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeQueryService(ServiceContext& host) {
  return std::make_unique<QueryServiceImpl>(host);
}

}  // namespace motiondb::server
