// Databases with the lowest and highest permitted frame rates.
#include <catch2/catch.hpp>
#include <string>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::frame_rates_test {
namespace {

// Checks that the query was answered, or refused as invalid.
void CheckAnswered(const grpc::Status& status) {
  INFO(status.error_message());
  const grpc::StatusCode code = status.error_code();
  CHECK((code == grpc::StatusCode::OK || code == grpc::StatusCode::INVALID_ARGUMENT ||
         code == grpc::StatusCode::FAILED_PRECONDITION));
}

template <typename Request, typename Method>
void CheckQuery(TestServer& server, const std::string& database, Method method) {
  Request request;
  request.set_database(database);
  *request.mutable_observation() = WalkObservation();
  const auto stub = server.NewStub<v1::QueryService>();
  CheckAnswered(Ask(*stub, method, request).status);
}

TEST_CASE("Databases: every permitted frame rate can be built and queried", "[server][rpc]") {
  TestServer server;
  const auto databases = server.NewStub<v1::DatabaseService>();
  // The first two have less than one frame in the seconds that a prediction looks back.
  for (const double rate : {1.0, 1.24, 3.0, 1000.0}) {
    CAPTURE(rate);
    const std::string id = "r" + std::to_string(static_cast<int>(100 * rate));
    v1::CreateDatabaseRequest request;
    request.set_database_id(id);
    request.mutable_database()->set_marker_set("source");
    request.mutable_database()->set_min_frames(4);
    request.mutable_database()->set_frame_rate_hz(rate);
    REQUIRE(Ask(*databases, &v1::DatabaseService::Stub::CreateDatabase, request).status.ok());
    std::string operation;
    for (int i = 0; i < 3; ++i) {
      const StickFigure figure{.frame_count = rate > 100 ? 30 : 300, .phase = 0.3 * i};
      const std::string name = "walk" + std::to_string(i);
      operation = server.IngestFigure(id, name, "walk", figure).operation().name();
    }
    const v1::Operation built = server.Wait(operation);
    INFO(built.ShortDebugString());
    CHECK(built.state() == v1::OPERATION_STATE_SUCCEEDED);
    using Queries = v1::QueryService::Stub;
    const std::string database = "databases/" + id;
    CheckQuery<v1::RecognizeRequest>(server, database, &Queries::Recognize);
    CheckQuery<v1::EstimateRequest>(server, database, &Queries::Estimate);
    CheckQuery<v1::PredictRequest>(server, database, &Queries::Predict);
  }
}

}  // namespace
}  // namespace motiondb::tests::frame_rates_test
