// GetServerStatus, the health of each service, and the statistics of calls.
#include <algorithm>
#include <catch2/catch.hpp>
#include <thread>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/listed_services.h"
#include "tests/server/rpc/status_of.h"

namespace motiondb::tests::server_status_test {
namespace {

using Catch::Contains;

TEST_CASE("GetServerStatus: an empty server", "[server][status]") {
  TestServer server;
  const auto status = StatusOf(server);
  CHECK(!status.version().empty());
  CHECK(status.serving());
  CHECK(!status.encrypted());
  CHECK(!status.authenticated());
  CHECK(status.call_count() == 0);
  CHECK(status.open_call_count() == 1);  // this call
  CHECK(status.methods().empty());
  CHECK(status.authentication_failure_count() == 0);
  CHECK(status.request_thread_count() >= 1);
  CHECK(status.memory_bytes() > 1 << 20);
  CHECK(status.thread_count() > 1);
  CHECK(status.open_file_count() > 3);
  CHECK(status.open_file_limit() >= status.open_file_count());
  CHECK(status.databases().empty());
  CHECK(status.corruptions().empty());
}

TEST_CASE("GetServerStatus: a database while its first model is built, and after",
          "[server][status]") {
  TestServer server;
  server.CreateDatabase("walks");
  server.gate().Close();
  const auto ingested = server.IngestFigure("walks", "walk", "walk", {.frame_count = 120});
  server.gate().AwaitArrival();
  const auto building = StatusOf(server);
  REQUIRE(building.databases_size() == 1);
  CHECK(building.databases(0).name() == "databases/walks");
  CHECK(building.databases(0).clip_count() == 1);
  CHECK(building.databases(0).model_version() == 0);
  CHECK(!building.databases(0).has_model_age());
  CHECK(building.databases(0).operation() == ingested.operation().name());
  CHECK(!building.databases(0).stage().empty());
  server.gate().Open();
  server.Wait(ingested.operation().name());
  const auto built = StatusOf(server);
  CHECK(built.databases(0).model_version() == 1);
  CHECK(built.databases(0).frame_count() == 120);
  CHECK(built.databases(0).has_model_age());
  CHECK(built.databases(0).operation().empty());
  CHECK(built.call_count() == 4);  // created, ingested, status, waited
  CHECK(built.failed_call_count() == 0);
  CHECK(built.databases(0).byte_count() > 120);
  CHECK(built.databases(0).has_model_build_time());
  CHECK(built.databases(0).succeeded_rebuild_count() == 1);
  CHECK(built.databases(0).failed_rebuild_count() == 0);
  CHECK(built.databases(0).cancelled_rebuild_count() == 0);
  CHECK(built.databases(0).has_rebuild_time());
}

TEST_CASE("Monitor: calls and streams of a real server", "[server][status]") {
  TestServer server;
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  v1::RecognizeRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = WalkObservation();
  CHECK(Ask(*queries, &v1::QueryService::Stub::Recognize, request).status.ok());
  request.set_database("databases/none");
  CHECK(!Ask(*queries, &v1::QueryService::Stub::Recognize, request).status.ok());
  {
    grpc::ClientContext context;
    const auto stub = server.NewStub<v1::ObserveService>();
    const auto stream = stub->Observe(&context);
    v1::ObserveRequest start;
    start.mutable_start()->set_database("databases/none");
    stream->Write(start);
    v1::ObserveResponse response;
    CHECK(!stream->Read(&response));
    CHECK(stream->Finish().error_code() == grpc::StatusCode::NOT_FOUND);
  }
  const auto status = StatusOf(server);
  const auto recognize =
      std::find_if(status.methods().begin(), status.methods().end(),
                   [](const auto& method) { return method.method() == "QueryService.Recognize"; });
  REQUIRE(recognize != status.methods().end());
  CHECK(recognize->call_count() == 2);
  REQUIRE(recognize->errors_size() == 1);
  CHECK(recognize->errors(0).code() == grpc::StatusCode::NOT_FOUND);
  CHECK(recognize->errors(0).call_count() == 1);
  CHECK(recognize->p50_time().nanos() + recognize->p50_time().seconds() > 0);
  const std::string text = server.server().monitor().Exposition();
  CHECK_THAT(
      text,
      Contains("motiondb_requests_total{code=\"OK\",method=\"QueryService.Recognize\"} 1\n") &&
          Contains("{code=\"NOT_FOUND\",method=\"QueryService.Recognize\"} 1\n") &&
          Contains("{code=\"NOT_FOUND\",method=\"ObserveService.Observe\"} 1\n") &&
          Contains("{code=\"OK\",method=\"ClipService.IngestClip\"} 3\n") &&
          Contains("motiondb_open_requests 0\n") && Contains("motiondb_open_streams 0\n"));
}

TEST_CASE("Health: services that add are NOT_SERVING while the store refuses additions",
          "[server][status]") {
  TestServer server;
  server.CreateDatabase("db");
  // Waits until the whole server has this health; HealthWatch checks every second.
  const auto await_health = [&](const std::string& health) {
    const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (CheckHealth(server).bytes != health) {
      REQUIRE(std::chrono::steady_clock::now() < latest);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  };
  CHECK(CheckHealth(server).bytes == kServing);
  CHECK(StatusOf(server).not_ready_reason().empty());
  server.disk().Set(SimulatedDisk::Lacks::kRoom);
  await_health(kNotServing);
  for (const std::string& service : ListOwnServices(server)) {
    CAPTURE(service);
    const bool adds = service.ends_with(".ClipService") || service.ends_with(".DatabaseService") ||
                      service.ends_with(".EditService") || service.ends_with(".SegmentService");
    CHECK(CheckHealth(server, service).bytes == (adds ? kNotServing : kServing));
  }
  CHECK_THAT(StatusOf(server).not_ready_reason(),
             Contains("nothing is stored") && Contains("disk is full"));
  CHECK(!server.server().monitor().CheckReadiness().ready);
  server.disk().Set(SimulatedDisk::Lacks::kNothing);
  await_health(kServing);
  CHECK(CheckHealth(server, "motiondb.v1.ClipService").bytes == kServing);
  CHECK(server.server().monitor().CheckReadiness().ready);
}

TEST_CASE("Monitor: not ready while the server drains", "[server][status]") {
  TestServer server;
  server.CreateDatabase("db");
  CHECK(server.server().monitor().CheckReadiness().ready);
  // A slow ingest delays the end of the drain.
  const auto stub = server.NewStub<v1::ClipService>();
  grpc::ClientContext context;
  v1::IngestClipResponse response;
  const auto writer = stub->IngestClip(&context, &response);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("walk.bvh");
  REQUIRE(writer->Write(message));
  while (StatusOf(server).open_call_count() < 2) std::this_thread::yield();
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(60)); });
  while (server.server().monitor().CheckReadiness().ready) std::this_thread::yield();
  CHECK_THAT(server.server().monitor().CheckReadiness().reason, Contains("draining"));
  CHECK(server.server().monitor().CollectStatistics().phase == server::Phase::kDraining);
  context.TryCancel();
  writer->Finish();
  draining.join();
}

}  // namespace
}  // namespace motiondb::tests::server_status_test
