// ListStreams and WatchStream: real streams and their spectators.
#include <grpcpp/security/credentials.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "tests/server/rpc/observing_client.h"
#include "tests/server/rpc/refusal.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::spectator_test {
namespace {

using grpc::StatusCode;
using observing::Frames;
using observing::Start;
using observing::Stream;
using observing::WalkingMarkers;
using Stub = v1::ObserveService::Stub;

Answer<v1::ListStreamsResponse> List(TestServer& server, const std::string& token = "",
                                     const std::string& database = "databases/db") {
  v1::ListStreamsRequest request;
  request.set_parent(database);
  return Ask(*server.NewStub<v1::ObserveService>(), &Stub::ListStreams, request, token);
}

// Returns the streams when there are `count`: a stream ends a moment after its client sees it.
std::vector<v1::ObservedStream> Streams(TestServer& server, int count) {
  while (true) {
    const auto listed = List(server);
    INFO(listed.status.error_message());
    REQUIRE(listed.status.ok());
    const auto& streams = listed.response.streams();
    if (streams.size() == count) return {streams.begin(), streams.end()};
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

// A spectator, which has read the description of the stream.
class SpectatorCall {
 public:
  SpectatorCall(TestServer& server, const std::string& name, const std::string& token = "",
                bool own_connection = false)
      : stub_(own_connection ? v1::ObserveService::NewStub(server.NewSmallChannel())
                             : server.NewStub<v1::ObserveService>()) {
    if (!token.empty()) context_.AddMetadata("authorization", "Bearer " + token);
    context_.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(10));
    v1::WatchStreamRequest request;
    request.set_name(name);
    reader_ = stub_->WatchStream(&context_, request);
    v1::WatchStreamResponse first;
    if (reader_->Read(&first)) stream = first.stream();
  }

  bool Read(v1::WatchStreamResponse& message) { return reader_->Read(&message); }
  v1::WatchStreamResponse Next() {
    v1::WatchStreamResponse message;
    REQUIRE(Read(message));
    CHECK_FALSE(message.has_stream());
    return message;
  }
  grpc::Status Finish() {
    v1::WatchStreamResponse none;
    while (reader_->Read(&none)) {
    }
    return reader_->Finish();
  }
  void Cancel() { context_.TryCancel(); }

  v1::ObservedStream stream;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<Stub> stub_;
  std::unique_ptr<grpc::ClientReader<v1::WatchStreamResponse>> reader_;
};

}  // namespace

TEST_CASE("WatchStream: spectators get the answers and positions of a stream", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  CHECK(List(server).response.streams().empty());
  Stream stream(server);
  v1::ObserveRequest start = Start(motion);
  start.mutable_start()->add_horizon_seconds(0.1);
  REQUIRE(stream.Send(start));
  stream.Ask(Frames(motion, 0, 4, 0));

  const std::vector<v1::ObservedStream> listed = Streams(server, 1);
  CHECK(listed[0].name().starts_with("databases/db/streams/"));
  CHECK(listed[0].frame() == 3);
  CHECK(listed[0].frame_rate_hz() == motion.frame_rate_hz());
  CHECK(listed[0].marker_names_size() == motion.marker_names_size());
  CHECK(listed[0].start_time().seconds() > 0);
  CHECK(listed[0].caller().empty());

  SpectatorCall one(server, listed[0].name());
  SpectatorCall two(server, listed[0].name());
  CHECK(one.stream.name() == listed[0].name());
  for (int first = 4; first + 4 <= 40; first += 4) {
    const v1::ObserveRequest frames = Frames(motion, first, 4, first);
    const v1::ObserveResponse answer = stream.Ask(frames);
    for (SpectatorCall* const spectator : {&one, &two}) {
      const v1::WatchStreamResponse seen = spectator->Next();
      CHECK(seen.answer().SerializeAsString() == answer.SerializeAsString());
      CHECK(seen.skipped_count() == 0);
      CHECK(seen.latency_seconds() > 0);
      CHECK(seen.latency_seconds() < 60);
      // The database has the markers of the motion at its rate, so they are the last frame's.
      const std::string& all = frames.frames().positions();
      const std::size_t width = all.size() / 4;
      CHECK(seen.marker_positions() == all.substr(3 * width));
    }
  }
  stream.Close();
  v1::ObserveResponse none;
  CHECK_FALSE(stream.Receive(none));
  CHECK(stream.Finish().ok());
  CHECK(one.Finish().ok());
  CHECK(two.Finish().ok());
  Streams(server, 0);
  CHECK(SpectatorCall(server, listed[0].name()).Finish().error_code() == StatusCode::NOT_FOUND);
}

TEST_CASE("WatchStream: ends when the stream's client is gone", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  REQUIRE(stream.Send(Start(motion)));
  stream.Ask(Frames(motion, 0, 4, 0));
  SpectatorCall spectator(server, Streams(server, 1)[0].name());
  stream.Cancel();
  CHECK(spectator.Finish().ok());
  CHECK(stream.Finish().error_code() == StatusCode::CANCELLED);
}

TEST_CASE("WatchStream: a slow spectator does not slow the stream down", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  REQUIRE(stream.Send(observing::StartOfLargeAnswers(motion)));
  stream.Ask(Frames(motion, 0, 4, 0));
  const std::string name = Streams(server, 1)[0].name();
  SpectatorCall slow(server, name, "", true);
  SpectatorCall gone(server, name, "", true);
  gone.Cancel();
  // Far more bytes than the flow-control windows have.
  constexpr int kMessages = 120;
  std::size_t bytes = 0;
  for (int i = 1; i <= kMessages; ++i) {
    bytes += stream.Ask(Frames(motion, i % motion.frame_count(), 1, 3 + i)).ByteSizeLong();
  }
  CHECK(bytes > std::size_t{3} << 19);
  std::int64_t last = 3;
  std::int64_t skipped = 0;
  v1::WatchStreamResponse message;
  while (last < 3 + kMessages && slow.Read(message)) {
    CHECK(message.answer().frame() == last + message.skipped_count() + 1);
    last = message.answer().frame();
    skipped += message.skipped_count();
  }
  CHECK(last == 3 + kMessages);
  CHECK(skipped > 0);
  stream.Close();
  CHECK(slow.Finish().ok());
}

TEST_CASE("WatchStream: ends with the database and with the server", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  REQUIRE(stream.Send(Start(motion)));
  stream.Ask(Frames(motion, 0, 4, 0));
  SpectatorCall spectator(server, Streams(server, 1)[0].name());
  SECTION("the database is deleted") {
    v1::DeleteDatabaseRequest deletion;
    deletion.set_name("databases/db");
    const auto databases = server.NewStub<v1::DatabaseService>();
    REQUIRE(Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase, deletion).status.ok());
    CHECK(spectator.Finish().error_code() == StatusCode::NOT_FOUND);
    CHECK(List(server).status.error_code() == StatusCode::NOT_FOUND);
    server.CreateDatabase("db");  // another database of that name
    CHECK(List(server).response.streams().empty());
  }
  SECTION("the server stops") {
    std::thread draining([&] { server.server().Drain(std::chrono::seconds(60)); });
    const grpc::Status ended = spectator.Finish();
    INFO(ended.error_message());
    CHECK(ended.error_code() == StatusCode::UNAVAILABLE);
    CHECK(ReasonOf(ended) == "SERVER_STOPPING");
    draining.join();
  }
}

TEST_CASE("WatchStream: access by database; a revoked token", "[server][rpc][security]") {
  TestServer server;
  server.CreateTrained("db");
  server.CreateDatabase("other");
  struct Made {
    std::string name;
    std::string secret;
  };
  const auto token = [&](v1::Role role, const std::string& database = "") {
    v1::CreateTokenRequest request;
    request.mutable_token()->set_role(role);
    request.mutable_token()->set_database(database);
    const auto made =
        Ask(*server.NewStub<v1::AccessService>(), &v1::AccessService::Stub::CreateToken, request);
    REQUIRE(made.status.ok());
    return Made{made.response.token().name(), made.response.secret()};
  };
  const Made admin = token(v1::ROLE_ADMIN);
  const Made reader = token(v1::ROLE_READER, "databases/db");
  const Made robot = token(v1::ROLE_READER, "databases/db");
  const Made stranger = token(v1::ROLE_READER, "databases/other");
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
  while (!Ask(
              *server.NewStub<v1::ObserveService>(), &Stub::Represent,
              [] {
                v1::RepresentRequest request;
                request.set_database("databases/db");
                *request.mutable_observation() = WalkObservation();
                return request;
              }(),
              robot.secret)
              .status.ok()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const v1::MarkerObservation motion = WalkingMarkers(server, robot.secret);
  Stream stream(server, robot.secret);
  REQUIRE(stream.Send(Start(motion)));
  stream.Ask(Frames(motion, 0, 4, 0));

  CHECK(List(server).status.error_code() == StatusCode::UNAUTHENTICATED);
  CHECK(List(server, stranger.secret).status.error_code() == StatusCode::PERMISSION_DENIED);
  CHECK(List(server, stranger.secret, "databases/other").response.streams().empty());
  const auto listed = List(server, reader.secret);
  REQUIRE(listed.response.streams_size() == 1);
  CHECK(listed.response.streams(0).caller() == robot.name);
  const std::string name = listed.response.streams(0).name();
  const auto code = [&](const std::string& of, const std::string& by) {
    return SpectatorCall(server, of, by).Finish().error_code();
  };
  CHECK(code(name, "") == StatusCode::UNAUTHENTICATED);
  CHECK(code(name, stranger.secret) == StatusCode::PERMISSION_DENIED);
  const std::string id = name.substr(name.rfind('/') + 1);
  CHECK(code("databases/other/streams/" + id, stranger.secret) == StatusCode::NOT_FOUND);
  CHECK(code("streams/" + id, admin.secret) == StatusCode::INVALID_ARGUMENT);

  SpectatorCall spectator(server, name, reader.secret);
  stream.Ask(Frames(motion, 4, 4, 4));
  spectator.Next();
  v1::RevokeTokenRequest revoke;
  revoke.set_name(reader.name);
  REQUIRE(Ask(*server.NewStub<v1::AccessService>(), &v1::AccessService::Stub::RevokeToken, revoke,
              admin.secret)
              .status.ok());
  stream.Ask(Frames(motion, 8, 4, 8));
  CHECK(spectator.Finish().error_code() == StatusCode::UNAUTHENTICATED);
  stream.Ask(Frames(motion, 12, 4, 12));  // unaffected
}

}  // namespace motiondb::tests::spectator_test
