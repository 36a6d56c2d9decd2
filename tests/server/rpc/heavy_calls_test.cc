// Which calls are heavy, and their limits.
#include <catch2/catch.hpp>
#include <chrono>
#include <deque>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "server/security/authorize.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::heavy_calls_test {
namespace {

using std::chrono::milliseconds;

TEST_CASE("RequestClass: the heavy and streaming calls exist in the protocol", "[server][limits]") {
  int heavy = 0;
  int streams = 0;
  int maintenance = 0;
  for (const server::CallRule& rule : server::CallRules()) {
    heavy += rule.request_class == server::RequestClass::kHeavy ? 1 : 0;
    streams += rule.request_class == server::RequestClass::kStream ? 1 : 0;
    maintenance += rule.pool == server::Pool::kMaintenance ? 1 : 0;
  }
  CHECK(heavy == 11);
  CHECK(streams == 3);
  CHECK(maintenance == 5);
}

// Few frames at the lowest accepted rate, which become 100 s of motion in a database of 60 Hz.
v1::Observation SlowMotion(TestServer& server) {
  v1::RepresentRequest represent;
  represent.set_database("databases/db");
  *represent.mutable_observation() = WalkObservation();
  const auto observe = server.NewStub<v1::ObserveService>();
  const auto walk = Ask(*observe, &v1::ObserveService::Stub::Represent, represent);
  REQUIRE(walk.status.ok());
  v1::Observation observation;
  v1::MarkerObservation& markers = *observation.mutable_markers();
  markers = walk.response.markers();
  const std::string walked = markers.positions();
  int frames = markers.frame_count();
  for (; frames < 200; frames += markers.frame_count()) *markers.mutable_positions() += walked;
  markers.set_frame_count(frames);
  markers.set_frame_rate_hz(2);
  REQUIRE(observation.ByteSizeLong() < 1 << 18);
  return observation;
}

TEST_CASE("Limits: a query about a long motion counts as a heavy call", "[server][limits]") {
  TestServer server(With({.heavy = {1, 1}}));
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  v1::RecognizeRequest short_one;
  short_one.set_database("databases/db");
  *short_one.mutable_observation() = WalkObservation();
  v1::RecognizeRequest long_one = short_one;
  long_one.mutable_observation()->mutable_file()->mutable_data()->append(2 << 20, '\n');
  const auto recognize = [&](const v1::RecognizeRequest& request) {
    return Ask(*queries, &v1::QueryService::Stub::Recognize, request).status;
  };
  const auto clips = server.NewStub<v1::ClipService>();
  v1::IngestClipRequest header;
  header.mutable_header()->set_parent("databases/db");
  header.mutable_header()->set_file_name("late.bvh");
  v1::IngestClipResponse stored;
  std::deque<grpc::ClientContext> contexts;
  std::vector<std::unique_ptr<grpc::ClientWriter<v1::IngestClipRequest>>> ingests;
  grpc::Status refused;
  for (int tries = 0; tries < 200 && refused.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED;
       ++tries) {
    // Repeated, because an ingest that meets a running query is refused itself.
    if (tries % 20 == 0) {
      ingests.push_back(clips->IngestClip(&contexts.emplace_back(), &stored));
      REQUIRE(ingests.back()->Write(header));
    }
    refused = recognize(long_one);
  }
  CheckRefusal(refused, "--max-heavy-calls");
  CHECK(recognize(short_one).ok());
  v1::RecognizeRequest slow_one = short_one;
  *slow_one.mutable_observation() = SlowMotion(server);
  CheckRefusal(recognize(slow_one), "--max-heavy-calls");
  for (grpc::ClientContext& context : contexts) context.TryCancel();
  grpc::Status free = recognize(slow_one);
  for (int tries = 0; tries < 500 && !free.ok(); ++tries) {
    std::this_thread::sleep_for(milliseconds(10));
    free = recognize(slow_one);
  }
  INFO(free.error_message());
  CHECK(free.ok());
}

// A file with minutes of motion: larger than a light call may be.
v1::Observation LongWalk() {
  v1::Observation observation = WalkObservation();
  observation.mutable_file()->set_data(WriteBvh({.act = Act::kWalk, .frame_count = 16000}));
  REQUIRE(observation.ByteSizeLong() > 1 << 20);
  return observation;
}

TEST_CASE("Limits: a heavy call counts before it waits for a thread", "[server][limits]") {
  TestServer server(With({.heavy = {2, 2}}));
  server.CreateTrained("db");
  std::promise<void> done;
  const std::shared_future<void> held = done.get_future().share();
  server::Workers& workers = server.server().engine().workers();
  for (int i = 0; i < workers.request_threads(); ++i) {
    workers.PostFair(server::Pool::kRequests, "", [held] { held.wait(); });
  }
  const auto queries = server.NewStub<v1::QueryService>();
  v1::RecognizeRequest request;
  request.set_database("databases/db");
  *request.mutable_observation() = LongWalk();
  const auto recognize = [&] {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + milliseconds(500));
    v1::RecognizeResponse response;
    return queries->Recognize(&context, request, &response);
  };
  // These calls wait for a thread and their clients have given up; they still count.
  CHECK(recognize().error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
  CHECK(recognize().error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
  grpc::Status refused = recognize();
  for (int tries = 0; tries < 20 && refused.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED;
       ++tries) {
    refused = recognize();
  }
  done.set_value();
  CheckRefusal(refused, "--max-heavy-calls");
}

TEST_CASE("Limits: incomplete files reserve memory", "[server][limits]") {
  TestServer server(With({.message_memory_bytes = 48 << 20}));
  server.CreateTrained("db");
  const auto clips = server.NewStub<v1::ClipService>();
  v1::IngestClipRequest header;
  header.mutable_header()->set_parent("databases/db");
  header.mutable_header()->set_file_name("slow.bvh");
  v1::IngestClipRequest block;
  block.set_file_block(std::string(1 << 20, ' '));
  const auto send = [&](grpc::ClientWriter<v1::IngestClipRequest>& ingest, int blocks) {
    bool open = ingest.Write(header);
    for (int i = 0; i < blocks && open; ++i) open = ingest.Write(block);
  };
  grpc::ClientContext slow;
  v1::IngestClipResponse ignored;
  const auto waiting = clips->IngestClip(&slow, &ignored);
  send(*waiting, 16);
  grpc::Status ended;
  // It is no motion file: until the first upload has reserved its memory, that is the error.
  for (int tries = 0; tries < 100 && ended.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED;
       ++tries) {
    grpc::ClientContext context;
    v1::IngestClipResponse response;
    const auto ingest = clips->IngestClip(&context, &response);
    send(*ingest, 12);
    ingest->WritesDone();
    ended = ingest->Finish();
  }
  slow.TryCancel();
  INFO(ended.error_message());
  CHECK(ended.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK(ended.error_message().find("--message-memory-mib") != std::string::npos);
}

TEST_CASE("Limits: a request reserves the memory of the parsed message", "[server][limits]") {
  TestServer server(With({.message_memory_bytes = 32 << 20}));
  server.CreateTrained("db");
  const auto queries = server.NewStub<v1::QueryService>();
  v1::PlanRequest request;
  request.set_database("databases/db");
  const auto plan = [&] { return Ask(*queries, &v1::QueryService::Stub::Plan, request).status; };
  CHECK(plan().error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  // 2 bytes each on the wire, much more as messages.
  for (int i = 0; i < 1'000'000; ++i) request.mutable_obstacles()->add_discs();
  REQUIRE(request.ByteSizeLong() < 4 << 20);
  const grpc::Status refused = plan();
  INFO(refused.error_message());
  CHECK(refused.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK(refused.error_message().find("--message-memory-mib") != std::string::npos);
  // A refused request releases its memory.
  request.mutable_obstacles()->mutable_discs()->DeleteSubrange(50'000, 950'000);
  for (int i = 0; i < 20; ++i) CHECK(plan().error_code() == grpc::StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace motiondb::tests::heavy_calls_test
