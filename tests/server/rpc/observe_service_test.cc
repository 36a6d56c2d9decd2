// Streams of frames to a server on a socket.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/operation.pb.h"
#include "tests/server/rpc/observing_client.h"
#include "tests/server/rpc/status_of.h"
#include "tests/support/camera_points.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::observe_service_test {
namespace {

using observing::Frames;
using observing::Start;
using observing::StartOfLargeAnswers;
using observing::Stream;
using observing::WalkingMarkers;
using Stub = v1::ObserveService::Stub;

}  // namespace

TEST_CASE("Observe: each message is answered in order, about all frames so far", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  v1::ObserveRequest start = Start(motion);
  start.mutable_start()->add_horizon_seconds(0.2);
  start.mutable_start()->add_horizon_seconds(0.1);
  REQUIRE(stream.Send(start));
  constexpr int kEach = 4;
  v1::ObserveResponse last;
  for (int first = 0; first + kEach <= motion.frame_count(); first += kEach) {
    last = stream.Ask(Frames(motion, first, kEach, 1000 + first));
    CHECK(last.frame() == 1000 + first + kEach - 1);
    CHECK(last.model_version() == 1);
    CHECK_FALSE(last.model_replaced());
    REQUIRE(last.has_state());
    CHECK(last.layer() > 0);
    CHECK(last.state().probability() > 0);
    REQUIRE(last.horizons_size() == 2);
    CHECK(last.horizons(0).seconds() == 0.2);
    CHECK(last.horizons(1).seconds() == 0.1);
    CHECK(last.horizons(0).marker_count() == motion.marker_names_size());
  }
  REQUIRE(last.labels_size() == 3);
  CHECK(last.labels(0).label() == "walk");
  CHECK(last.late_frames() == 0);
  CHECK(last.missing_frames() == 0);
  stream.Close();
  v1::ObserveResponse none;
  CHECK_FALSE(stream.Receive(none));
  CHECK(stream.Finish().ok());
}

v1::MarkerObservation SeenByCamera(const v1::MarkerObservation& motion) {
  v1::MarkerObservation seen;
  seen.set_frame_rate_hz(motion.frame_rate_hz());
  seen.set_frame_count(motion.frame_count());
  for (const auto& [name, marker] : kCameraPoints) seen.add_marker_names(name);
  constexpr std::size_t kPoint = 3 * sizeof(float);
  for (int frame = 0; frame < motion.frame_count(); ++frame) {
    for (const auto& [name, marker] : kCameraPoints) {
      const auto at = std::ranges::find(motion.marker_names(), marker);
      REQUIRE(at != motion.marker_names().end());
      const auto index = frame * motion.marker_names_size() + (at - motion.marker_names().begin());
      seen.mutable_positions()->append(motion.positions(), index * kPoint, kPoint);
    }
  }
  return seen;
}

TEST_CASE("Observe: a camera's 17 points are mapped automatically", "[server][rpc][data]") {
  MOTIONDB_REQUIRE_DATA();
  TestServer server;
  v1::CreateDatabaseRequest create;
  create.set_database_id("db");
  REQUIRE(Ask(*server.NewStub<v1::DatabaseService>(), &v1::DatabaseService::Stub::CreateDatabase,
              create)
              .status.ok());
  v1::RepresentRequest represent;
  represent.set_database("databases/db");
  v1::IngestClipResponse ingested;
  for (const char* name : {"13/13_11.bvh", "10/10_01.bvh"}) {
    v1::IngestClipHeader header;
    header.set_parent("databases/db");
    header.set_file_name("motion.bvh");
    header.set_label(name);
    auto& file = *represent.mutable_observation()->mutable_file();
    file.set_file_name("motion.bvh");
    file.set_data(ReadFile(DataDir() / "cmu" / name));
    REQUIRE(server.Ingest(header, file.data(), &ingested).ok());
  }
  REQUIRE(server.Wait(ingested.operation().name()).state() == v1::OPERATION_STATE_SUCCEEDED);
  const auto stub = server.NewStub<v1::ObserveService>();
  const auto markers = Ask(*stub, &Stub::Represent, represent);
  REQUIRE(markers.status.ok());
  const v1::MarkerObservation seen = SeenByCamera(markers.response.markers());

  Stream stream(server);
  REQUIRE(stream.Send(Start(seen)));
  v1::ObserveRequest hidden = Frames(seen, 20, 1, 20);  // one point is not seen
  std::string missing;
  for (int axis = 0; axis < 3; ++axis) missing += std::string("\x00\x00\xc0\x7f", 4);
  hidden.mutable_frames()->mutable_positions()->replace(0, missing.size(), missing);
  CHECK_FALSE(stream.Ask(hidden).has_state());
  const auto answer = stream.Ask(Frames(seen, 21, 200, 21));
  REQUIRE(answer.has_state());
  // Markers that the camera does not see are missing, which changes little.
  Stream full(server);
  REQUIRE(full.Send(Start(markers.response.markers())));
  const auto expected = full.Ask(Frames(markers.response.markers(), 20, 201, 20));
  REQUIRE(answer.labels_size() == 2);
  CHECK(answer.labels(0).label() == "10/10_01.bvh");
  CHECK(answer.labels(0).label() == expected.labels(0).label());
  CHECK(answer.familiarity() == Approx(expected.familiarity()).margin(0.1));
  CHECK(answer.state().probability() > 0.5);
  stream.Close();
  CHECK(stream.Finish().ok());
  CHECK(ViolatedFields([&] {
          v1::ObserveRequest unknown = Start(seen);
          unknown.mutable_start()->set_marker_names(0, "hat");
          unknown.mutable_start()->set_marker_names(13, "box");  // no left knee
          Stream refused(server);
          refused.Send(unknown);
          v1::ObserveResponse response;
          while (refused.Receive(response)) {
          }
          return refused.Finish();
        }()) == "start.marker_names");
}

TEST_CASE("Observe: late frames are ignored, frames that never arrive are missing",
          "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  REQUIRE(stream.Send(Start(motion)));
  stream.Ask(Frames(motion, 0, 10, 0));
  const auto repeated = stream.Ask(Frames(motion, 8, 4, 8));
  CHECK(repeated.late_frames() == 2);
  CHECK(repeated.frame() == 11);
  const auto skipped = stream.Ask(Frames(motion, 14, 2, 14));
  CHECK(skipped.missing_frames() == 2);
  CHECK(skipped.frame() == 15);
  const auto late = stream.Ask(Frames(motion, 0, 4, 0));
  CHECK(late.late_frames() == 6);
  CHECK(late.frame() == 15);
  stream.Close();
  CHECK(stream.Finish().ok());
}

TEST_CASE("Observe: the error names the invalid field", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  const auto refused = [&](const std::vector<v1::ObserveRequest>& requests) {
    Stream stream(server);
    for (const auto& request : requests) stream.Send(request);
    v1::ObserveResponse response;
    while (stream.Receive(response)) {
    }
    return stream.Finish();
  };
  const v1::ObserveRequest good = Start(motion);
  const auto started = [&](const std::function<void(v1::ObserveStart&)>& change) {
    v1::ObserveRequest request = good;
    change(*request.mutable_start());
    return refused({request});
  };
  CHECK(ViolatedFields(refused({v1::ObserveRequest()})) == "part");
  CHECK(ViolatedFields(refused({Frames(motion, 0, 1, 0)})) == "part");
  CHECK(ViolatedFields(refused({good, good})) == "start");
  CHECK(started([](auto& start) { start.set_database("databases/none"); }).error_code() ==
        grpc::StatusCode::NOT_FOUND);
  CHECK(ViolatedFields(started([](auto& start) { start.set_database("db"); })) == "start.database");
  CHECK(ViolatedFields(started([](auto& start) { start.set_frame_rate_hz(0); })) ==
        "start.frame_rate_hz");
  CHECK(ViolatedFields(started([](auto& start) { start.set_leg_length_m(85); })) ==
        "start.leg_length_m");
  CHECK(ViolatedFields(started([](auto& start) { start.set_leg_length_m(-1); })) ==
        "start.leg_length_m");
  CHECK(ViolatedFields(started([](auto& start) { start.add_horizon_seconds(-1); })) ==
        "start.horizon_seconds[0]");
  CHECK(ViolatedFields(started([](auto& start) { start.set_layer(99); })) == "start.layer");
  CHECK(ViolatedFields(started([](auto& start) { start.set_transition_floor(2); })) ==
        "start.transition_floor");
  CHECK(ViolatedFields(started([](auto& start) { start.set_top_count(0); })) == "start.top_count");
  CHECK(ViolatedFields(started([](auto& start) {
          start.clear_marker_names();
          start.add_marker_names("nothing");
        })) == "start");
  v1::ObserveRequest wide = Frames(motion, 0, 2, 0);
  wide.mutable_frames()->set_frame_count(3);
  CHECK(ViolatedFields(refused({good, wide})) == "frames.positions");
  wide.mutable_frames()->set_frame_count(0);
  CHECK(ViolatedFields(refused({good, wide})) == "frames.frame_count");
  v1::ObserveRequest infinite = Frames(motion, 0, 1, 0);
  infinite.mutable_frames()->mutable_positions()->replace(0, 4, "\x00\x00\x80\x7f", 4);
  CHECK(ViolatedFields(refused({good, infinite})) == "frames.positions");
  v1::ObserveRequest beyond = Frames(motion, 0, 2, std::numeric_limits<std::int64_t>::max());
  CHECK(ViolatedFields(refused({good, beyond})) == "frames");
}

TEST_CASE("Observe: the stream uses a new model and announces it once", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server);
  REQUIRE(stream.Send(Start(motion)));
  CHECK(stream.Ask(Frames(motion, 0, 8, 0)).model_version() == 1);
  const auto ingested = server.IngestFigure("db", "more", "stroll", {.phase = 2});
  server.Wait(ingested.operation().name());
  const auto first = stream.Ask(Frames(motion, 8, 8, 8));
  CHECK(first.model_version() == 2);
  CHECK(first.model_replaced());
  CHECK(first.labels_size() == 4);
  CHECK_FALSE(stream.Ask(Frames(motion, 16, 8, 16)).model_replaced());

  v1::DeleteDatabaseRequest deletion;
  deletion.set_name("databases/db");
  const auto databases = server.NewStub<v1::DatabaseService>();
  REQUIRE(Ask(*databases, &v1::DatabaseService::Stub::DeleteDatabase, deletion).status.ok());
  stream.Send(Frames(motion, 24, 8, 24));
  v1::ObserveResponse none;
  CHECK_FALSE(stream.Receive(none));
  CHECK(stream.Finish().error_code() == grpc::StatusCode::NOT_FOUND);
}

TEST_CASE("Observe: the server stops reading from a client that does not read", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server.NewSmallChannel());
  REQUIRE(stream.Send(StartOfLargeAnswers(motion)));
  // Far more than the flow-control windows of both directions.
  constexpr int kMessages = 3000;
  std::atomic<int> sent = 0;
  std::thread sender([&] {
    while (sent < kMessages && stream.Send(Frames(motion, 0, motion.frame_count(),
                                                  std::int64_t{sent} * motion.frame_count()))) {
      ++sent;
    }
  });
  const auto settled = [&] {
    int before = -1;
    for (int tries = 0; tries < 100 && before != sent; ++tries) {
      before = sent;
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    return sent.load();
  };
  CHECK(settled() < kMessages);
  v1::ObserveResponse response;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(stream.Receive(response));
    CHECK(response.frame() == (i + 1) * motion.frame_count() - 1);
  }
  stream.Cancel();
  sender.join();
  CHECK(stream.Finish().error_code() == grpc::StatusCode::CANCELLED);
}

TEST_CASE("Observe: a client that reads no responses is disconnected", "[server][rpc]") {
  server::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.engine.rebuild_delay = std::chrono::milliseconds(50);
  options.calls.idle_limit = std::chrono::milliseconds(300);
  TestServer server(options);
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream stream(server.NewSmallChannel());
  REQUIRE(stream.Send(StartOfLargeAnswers(motion)));
  std::int64_t sent = 0;
  while (stream.Send(
      Frames(motion, 0, motion.frame_count(), sent * std::int64_t{motion.frame_count()}))) {
    ++sent;
  }
  v1::ObserveResponse response;
  while (stream.Receive(response)) {
  }
  CHECK(stream.Finish().error_code() == grpc::StatusCode::CANCELLED);
}

TEST_CASE("Observe: a stream is counted for its database while it is open", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  server.CreateDatabase("other");
  const auto count_streams = [&] {
    const v1::GetServerStatusResponse status = StatusOf(server);
    std::map<std::string, int> counts;
    for (const v1::DatabaseStatus& database : status.databases()) {
      counts[database.name()] = database.open_stream_count();
    }
    return counts;
  };
  const v1::MarkerObservation motion = WalkingMarkers(server);
  {
    Stream stream(server);
    REQUIRE(stream.Send(Start(motion)));
    stream.Ask(Frames(motion, 0, 4, 0));
    CHECK(count_streams() ==
          std::map<std::string, int>{{"databases/db", 1}, {"databases/other", 0}});
    CHECK_THAT(server.server().monitor().Exposition(),
               Catch::Contains("motiondb_database_streams{database=\"db\"} 1\n"));
  }
  // The server notices the end a moment later.
  while (count_streams()["databases/db"] > 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

TEST_CASE("Observe: a stopping server ends idle streams immediately", "[server][rpc]") {
  TestServer server;
  server.CreateTrained("db");
  const v1::MarkerObservation motion = WalkingMarkers(server);
  Stream idle(server);
  REQUIRE(idle.Send(Start(motion)));
  idle.Ask(Frames(motion, 0, 4, 0));
  Stream silent(server);  // without a first message, but open at the server
  while (StatusOf(server).open_stream_count() < 2) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::thread draining([&] { server.server().Drain(std::chrono::seconds(60)); });
  v1::ObserveResponse none;
  CHECK_FALSE(idle.Receive(none));
  CHECK(idle.Finish().error_code() == grpc::StatusCode::UNAVAILABLE);
  CHECK_FALSE(silent.Receive(none));
  CHECK(silent.Finish().error_code() == grpc::StatusCode::UNAVAILABLE);
  draining.join();
}

}  // namespace motiondb::tests::observe_service_test
