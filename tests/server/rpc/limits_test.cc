// Limits of clients: calls in flight, duration, idle timeout.
#include <catch2/catch.hpp>
#include <chrono>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/operation.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "motiondb/v1/store.grpc.pb.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/captured_log.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::limits_test {
namespace {

using std::chrono::milliseconds;

v1::ObserveRequest Start() {
  v1::ObserveRequest request;
  request.mutable_start()->set_database("databases/db");
  request.mutable_start()->set_frame_rate_hz(60);
  return request;
}

// A stream whose first frame was answered, so it is counted. The destructor ends it.
class AnsweredStream {
 public:
  explicit AnsweredStream(TestServer& server)
      : stub_(server.NewStub<v1::ObserveService>()), stream_(stub_->Observe(&context_)) {
    v1::RepresentRequest represent;
    represent.set_database("databases/db");
    *represent.mutable_observation() = WalkObservation();
    const auto walk = Ask(*stub_, &v1::ObserveService::Stub::Represent, represent);
    REQUIRE(walk.status.ok());
    const v1::MarkerObservation& markers = walk.response.markers();
    REQUIRE(stream_->Write(Start()));
    v1::ObserveRequest frame;
    frame.mutable_frames()->set_frame_count(1);
    frame.mutable_frames()->set_positions(
        markers.positions().substr(0, markers.positions().size() / markers.frame_count()));
    REQUIRE(stream_->Write(frame));
    v1::ObserveResponse answer;
    REQUIRE(stream_->Read(&answer));
  }
  ~AnsweredStream() {
    stream_->WritesDone();
    CHECK(stream_->Finish().ok());
  }

 private:
  const std::unique_ptr<v1::ObserveService::Stub> stub_;
  grpc::ClientContext context_;
  const std::unique_ptr<grpc::ClientReaderWriter<v1::ObserveRequest, v1::ObserveResponse>> stream_;
};

// `two`: limits for two streams. `setting`: the expected name in the error.
void CheckThirdStream(const server::CallLimit& two, const std::string& setting) {
  TestServer server(With({.streams = two}));
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ObserveService>();
  const auto observe = [&] {
    grpc::ClientContext context;
    const auto stream = stub->Observe(&context);
    stream->Write(Start());
    v1::ObserveResponse response;
    stream->WritesDone();
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  };
  {
    const AnsweredStream first(server);
    const AnsweredStream second(server);
    CheckRefusal(observe(), setting);
  }
  const grpc::Status retried = observe();
  INFO(retried.error_message());
  CHECK(retried.ok());
}

TEST_CASE("Limits: streams above the total limit are refused until one has ended",
          "[server][limits]") {
  CheckThirdStream({.in_all = 2, .per_client = 8}, "a quarter of --max-calls");
}

TEST_CASE("Limits: streams above the limit of a client are refused until one has ended",
          "[server][limits]") {
  CheckThirdStream({.in_all = 8, .per_client = 2}, "a 16th of --max-calls");
}

TEST_CASE("Limits: a call with too much metadata is refused, and other calls continue",
          "[server][limits]") {
  TestServer server(With({.max_metadata_bytes = 4 << 10}));
  const auto list = [&](std::size_t bytes, const std::shared_ptr<grpc::Channel>& channel) {
    const auto stub = v1::DatabaseService::NewStub(channel);
    grpc::ClientContext context;
    context.AddMetadata("x-load", std::string(bytes, 'x'));
    v1::ListDatabasesResponse response;
    grpc::Status status = stub->ListDatabases(&context, {}, &response);
    UNSCOPED_INFO(bytes << " bytes: " << status.error_message());
    return status;
  };
  const auto client = server.channel();
  CHECK(list(3 << 10, client).ok());
  const grpc::Status refused = list(5 << 10, client);
  CHECK(refused.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK(refused.error_message().find("bytes of metadata") != std::string::npos);
  CHECK(list(3 << 10, client).ok());
  // Far too much ends the connection of the sender, and no other.
  const auto other_channel = server.NewChannel();
  CHECK(list(3 << 10, other_channel).ok());
  CHECK(!list(1 << 20, client).ok());
  CHECK(list(3 << 10, other_channel).ok());
}

TEST_CASE("Limits: a request that is too large is refused", "[server][limits]") {
  server::ServerOptions options = With({});
  options.max_message_bytes = 1 << 20;
  TestServer server(options);
  v1::RecognizeRequest request;
  request.set_database(std::string(2 << 20, 'x'));
  const auto queries = server.NewStub<v1::QueryService>();
  const grpc::Status status = Ask(*queries, &v1::QueryService::Stub::Recognize, request).status;
  CHECK(status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  server.CreateDatabase("db");
}

TEST_CASE("Limits: compressed messages are refused", "[server][limits]") {
  TestServer server;
  v1::RecognizeRequest request;
  request.set_database(std::string(1 << 20, 'x'));
  const auto queries = server.NewStub<v1::QueryService>();
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext context;
    context.set_compression_algorithm(algorithm);
    v1::RecognizeResponse response;
    const grpc::Status status = queries->Recognize(&context, request, &response);
    CHECK(status.error_code() == grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST_CASE("Limits: the stream of an idle client ends", "[server][limits]") {
  TestServer server(With({.idle_limit = milliseconds(200)}));
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ObserveService>();
  grpc::ClientContext context;
  const auto stream = stub->Observe(&context);
  REQUIRE(stream->Write(Start()));
  v1::ObserveResponse response;
  CHECK(!stream->Read(&response));
  const grpc::Status status = stream->Finish();
  INFO(status.error_message());
  CHECK(status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
  CHECK(status.error_message().find("--silence-limit") != std::string::npos);
}

TEST_CASE("Limits: an ingest that is never finished stores nothing and ends", "[server][limits]") {
  TestServer server(With({.idle_limit = milliseconds(200)}));
  server.CreateDatabase("db");
  const auto stub = server.NewStub<v1::ClipService>();
  grpc::ClientContext context;
  v1::IngestClipResponse response;
  const auto writer = stub->IngestClip(&context, &response);
  v1::IngestClipRequest message;
  message.mutable_header()->set_parent("databases/db");
  message.mutable_header()->set_file_name("walk.bvh");
  REQUIRE(writer->Write(message));
  const grpc::Status status = writer->Finish();  // without WritesDone
  INFO(status.error_message());
  CHECK(status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
  CHECK(server.Describe("db").stored_clip_count() == 0);
  // The build does not wait for it: the next clip has its model soon.
  const auto next = server.IngestFigure("db", "squat", "squat", {});
  CHECK(IsDone(server.Wait(next.operation().name())));
}

TEST_CASE("Limits: a stream without a first message ends soon", "[server][limits]") {
  auto options = With({.first_idle_limit = milliseconds(200)});
  options.security.authentication = server::Authentication::kToken;
  TestServer server(options);
  const auto end_of = [](const auto& stream) {
    const grpc::Status status = stream->Finish();
    INFO(status.error_message());
    CHECK(status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
    CHECK(status.error_message().find("no first message within 0.2 s") != std::string::npos);
  };
  grpc::ClientContext observing, ingesting, restoring;
  v1::IngestClipResponse ingested;
  v1::RestoreStoreResponse restored;
  const auto observe = server.NewStub<v1::ObserveService>()->Observe(&observing);
  const auto ingest = server.NewStub<v1::ClipService>()->IngestClip(&ingesting, &ingested);
  const auto restore = server.NewStub<v1::StoreService>()->RestoreStore(&restoring, &restored);
  end_of(observe);
  end_of(ingest);
  end_of(restore);
}

TEST_CASE("Limits: after its first message a stream may be idle longer", "[server][limits]") {
  TestServer server(With({.first_idle_limit = milliseconds(200)}));
  server.CreateTrained("db");
  const auto stub = server.NewStub<v1::ObserveService>();
  grpc::ClientContext context;
  const auto stream = stub->Observe(&context);
  REQUIRE(stream->Write(Start()));
  std::this_thread::sleep_for(milliseconds(600));
  stream->WritesDone();
  CHECK(stream->Finish().ok());
}

TEST_CASE("Limits: a call ends at the server's time limit", "[server][limits]") {
  TestServer server(With({.max_call_time = milliseconds(0)}));
  const auto stub = server.NewStub<v1::DatabaseService>();
  const auto answer = Ask(*stub, &v1::DatabaseService::Stub::ListDatabases, {});
  INFO(answer.status.error_message());
  CHECK(answer.status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);
  CHECK(answer.status.error_message().find("--call-time-limit") != std::string::npos);
}

// Returns the log lines, "CODE message", of calls that end after their client's deadline.
std::set<std::string> LogOfLateCalls(std::size_t count) {
  TestServer server(With({}));
  const CapturedLog log(spdlog::level::debug);
  std::promise<void> done;
  const std::shared_future<void> held = done.get_future().share();
  server::Workers& workers = server.server().engine().workers();
  for (int i = 0; i < workers.request_threads(); ++i) {
    workers.Post(server::Pool::kRequests, [held] { held.wait(); });
  }
  const auto stub = server.NewStub<v1::DatabaseService>();
  const v1::ListDatabasesRequest request;
  std::vector<grpc::ClientContext> contexts(count);
  std::vector<v1::ListDatabasesResponse> responses(count);
  std::vector<std::promise<void>> ends(count);
  const auto deadline = std::chrono::system_clock::now() + milliseconds(500);
  for (std::size_t i = 0; i < count; ++i) {
    contexts[i].set_deadline(deadline);
    stub->async()->ListDatabases(&contexts[i], &request, &responses[i],
                                 [&end = ends[i]](const grpc::Status&) { end.set_value(); });
  }
  for (auto& end : ends) end.get_future().wait();
  std::this_thread::sleep_for(milliseconds(200));  // until it has passed at the server, too
  done.set_value();
  server.Stop();
  std::set<std::string> lines;
  std::istringstream text(log.text());
  for (std::string line; std::getline(text, line);) {
    const auto json = nlohmann::json::parse(line);
    if (json.value("method", "") != "DatabaseService.ListDatabases") continue;
    lines.insert(json["code"].get<std::string>() + " " + json["message"].get<std::string>());
  }
  return lines;
}

TEST_CASE("Limits: a client's deadline is not reported as the server's limit", "[server][limits]") {
  CHECK(LogOfLateCalls(200) == std::set<std::string>{"DEADLINE_EXCEEDED call: the call took longer "
                                                     "than the client's deadline"});
}

TEST_CASE("Limits: a wait for an operation has its own timeout, not that of calls",
          "[server][limits]") {
  server::ServerOptions options = With({});
  options.engine.rebuild_delay = options.engine.rebuild_delay_limit = std::chrono::minutes(2);
  TestServer server(options);
  server.CreateDatabase("db");
  const std::string name = server.IngestFigure("db", "walk", "walk", {}).operation().name();
  server.options().calls.max_call_time = milliseconds(0);
  server.Restart();
  v1::WaitOperationRequest request;
  request.set_name(name);
  request.mutable_timeout()->set_nanos(200'000'000);
  const auto began = std::chrono::steady_clock::now();
  const auto answer = Ask(*server.NewStub<v1::OperationService>(),
                          &v1::OperationService::Stub::WaitOperation, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  CHECK(!IsDone(answer.response.operation()));
  CHECK(std::chrono::steady_clock::now() - began >= milliseconds(200));
}

}  // namespace
}  // namespace motiondb::tests::limits_test
