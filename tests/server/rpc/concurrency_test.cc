// Many concurrent clients while models are rebuilt.
#include <atomic>
#include <catch2/catch.hpp>
#include <mutex>
#include <set>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::concurrency_test {
namespace {

using Stub = v1::QueryService::Stub;

TEST_CASE("Concurrency: 32 clients query during rebuilds without an error", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  std::atomic<bool> stop{false};
  std::atomic<int> answered{0};
  std::mutex mutex;
  std::set<std::string> errors;
  std::set<int> clip_counts;  // numbers of clips in the models that answered
  std::vector<std::thread> clients;
  for (int i = 0; i < 32; ++i) {
    clients.emplace_back([&] {
      const auto stub = server.NewStub<v1::QueryService>();
      v1::RecognizeRequest request;
      request.set_database("databases/db");
      *request.mutable_observation() = WalkObservation();
      while (!stop) {
        const auto answer = Ask(*stub, &Stub::Recognize, request);
        std::unique_lock lock(mutex);
        if (!answer.status.ok()) errors.insert(answer.status.error_message());
        for (const auto& window : answer.response.windows()) {
          // A partly replaced model would rank another number of clips.
          clip_counts.insert(window.clips_size());
        }
        lock.unlock();
        ++answered;
      }
    });
  }
  std::string operation;
  for (int i = 0; i < 3; ++i) {
    const auto ingested =
        server.IngestFigure("db", "more", "walk", {.frame_count = 240, .phase = 0.5 + i});
    operation = ingested.operation().name();
    CHECK(server.Wait(operation).state() == v1::OPERATION_STATE_SUCCEEDED);
  }
  const int so_far = answered;
  while (answered < so_far + 64) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  stop = true;
  for (std::thread& client : clients) client.join();
  for (const std::string& error : errors) UNSCOPED_INFO(error);
  CHECK(errors.empty());
  CHECK(server.Describe("db").model_version() == 4);
  CHECK(*clip_counts.begin() == 3);
  CHECK(*clip_counts.rbegin() == 6);
  WARN("answered " << answered << " queries from 32 clients during 3 rebuilds");
}

TEST_CASE("Concurrency: queries are answered while a build is blocked", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  server.gate().Close();
  const auto ingested = server.IngestFigure("db", "more", "walk", {.phase = 2});
  server.gate().AwaitArrival();
  const auto stub = server.NewStub<v1::QueryService>();
  v1::RecognizeRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = WalkObservation();
  const auto during = Ask(*stub, &Stub::Recognize, request);
  REQUIRE(during.status.ok());
  CHECK(during.response.windows(0).clips_size() == 3);
  CHECK(server.Describe("db").stored_clip_count() == 4);
  server.gate().Open();
  server.Wait(ingested.operation().name());
  CHECK(Ask(*stub, &Stub::Recognize, request).response.windows(0).clips_size() == 4);
}

TEST_CASE("Concurrency: a restarted server answers as before, without rebuilding",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  v1::EstimateRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = WalkObservation();
  const auto ask = [&] {
    const auto stub = server.NewStub<v1::QueryService>();
    const auto answer = Ask(*stub, &Stub::Estimate, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    return answer.response.SerializeAsString();
  };
  const std::string before = ask();
  const auto described = server.Describe("db").SerializeAsString();
  server.Stop();
  server.gate().Close();
  server.Start();
  CHECK(ask() == before);
  CHECK(server.Describe("db").SerializeAsString() == described);
}

}  // namespace
}  // namespace motiondb::tests::concurrency_test
