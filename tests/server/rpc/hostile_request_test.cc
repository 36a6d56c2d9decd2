// Small requests with large costs: each is refused with its field, or ends at its deadline, and its
// thread is free again.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <thread>

#include "motiondb/v1/clip.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/observe.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::hostile_request_test {
namespace {

using Catch::Contains;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr int kMaxFrames = 100'000;
constexpr milliseconds kSoon{50};    // deadline of a request that would take far longer
constexpr seconds kMaxRecovery{20};  // far less than that, also on a slow machine
constexpr int kAny = std::numeric_limits<int>::max();

server::ServerOptions OneThread() {
  server::ServerOptions options;
  options.engine.rebuild_delay = milliseconds(50);
  options.engine.extend_from = std::chrono::hours(1);
  options.engine.query_threads = 1;
  options.engine.max_frames = kMaxFrames;
  return options;
}

// A trained database on a server with one request thread, which must not be blocked.
class Victim {
 public:
  explicit Victim(const server::ServerOptions& options = OneThread())
      : server_(options), query_(server_.NewStub<v1::QueryService>()) {
    server_.CreateTrained("db");
  }

  TestServer& server() { return server_; }
  v1::QueryService::Stub& query() { return *query_; }

  // The walk as markers of the database, repeated, at `rate_hz`.
  v1::Observation Markers(int frames, double rate_hz = 60) {
    v1::RepresentRequest request;
    request.set_database("databases/db");
    *request.mutable_observation() = WalkObservation();
    const auto stub = server_.NewStub<v1::ObserveService>();
    const auto answer = Ask(*stub, &v1::ObserveService::Stub::Represent, request);
    REQUIRE(answer.status.ok());
    v1::Observation observation;
    *observation.mutable_markers() = answer.response.markers();
    const std::string& positions = answer.response.markers().positions();
    const std::size_t bytes = positions.size() / answer.response.markers().frame_count() *
                              static_cast<std::size_t>(frames);
    std::string tiled;
    tiled.reserve(bytes + positions.size());
    while (tiled.size() < bytes) tiled += positions;
    tiled.resize(bytes);
    observation.mutable_markers()->set_frame_count(frames);
    observation.mutable_markers()->set_frame_rate_hz(rate_hz);
    observation.mutable_markers()->set_positions(std::move(tiled));
    return observation;
  }

  // The call must end at its deadline, and the next call must be answered soon.
  template <typename Request, typename Response>
  void EndsWithItsDeadline(grpc::Status (v1::QueryService::Stub::*method)(grpc::ClientContext*,
                                                                          const Request&,
                                                                          Response*),
                           const Request& request) {
    grpc::ClientContext hostile;
    hostile.set_deadline(std::chrono::system_clock::now() + kSoon);
    Response unused;
    const grpc::Status status = ((*query_).*method)(&hostile, request, &unused);
    INFO(status.error_message());
    CHECK(status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED);

    v1::GetDatabaseRequest next;
    next.set_name("databases/db");
    v1::GetDatabaseResponse database;
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kMaxRecovery);
    const grpc::Status free =
        server_.NewStub<v1::DatabaseService>()->GetDatabase(&context, next, &database);
    INFO(free.error_message());
    CHECK(free.ok());
  }

 private:
  TestServer server_;
  std::unique_ptr<v1::QueryService::Stub> query_;
};

void CheckRefused(const grpc::Status& status, const std::string& field) {
  INFO(status.error_message());
  CHECK(status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  CHECK(ViolatedFields(status) == field);
}

void CheckTooLong(const grpc::Status& status) {
  INFO(status.error_message());
  CHECK(status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK_THAT(status.error_message(), Contains("(--max-frames): split it"));
}

// A robot with a chain of links.
std::string ChainRobot(int joints, const char* type) {
  std::string text = "<robot name=\"chain\"><link name=\"l0\"/>";
  for (int j = 1; j <= joints; ++j) {
    text += fmt::format(
        "<link name=\"l{0}\"/><joint name=\"j{0}\" type=\"{2}\"><parent link=\"l{1}\"/>"
        "<child link=\"l{0}\"/></joint>",
        j, j - 1, type);
  }
  return text + "</robot>";
}

// A BVH file: a root with hips and `others` more joints beside them.
std::string ManyJointsFile(int others, int frames = 4) {
  std::string text =
      "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition "
      "Zposition\n";
  const auto joint = [&](const std::string& name, int x) {
    text += fmt::format(
        "JOINT {}\n{{\nOFFSET {} 90 0\nCHANNELS 0\nEnd Site\n{{\nOFFSET 0 1 0\n}}\n"
        "}}\n",
        name, x);
  };
  joint("LeftUpLeg", 10);
  joint("RightUpLeg", -10);
  for (int i = 0; i < others; ++i) joint(fmt::format("j{}", i), i);
  text += fmt::format("}}\nMOTION\nFrames: {}\nFrame Time: 0.0166667\n", frames);
  for (int t = 0; t < frames; ++t) text += "0 0 0\n";
  return text;
}

TEST_CASE("Hostile request: too many frames are refused at any frame rate",
          "[server][rpc][hostile]") {
  Victim victim;
  // A fraction of a second: at the database's frame rate it would have few frames.
  const v1::Observation observation = victim.Markers(kMaxFrames + 1, 1e6);
  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  *recognize.mutable_observation() = observation;
  CheckTooLong(Ask(victim.query(), &v1::QueryService::Stub::Recognize, recognize).status);
  v1::RepresentRequest represent;
  represent.set_database("databases/db");
  *represent.mutable_observation() = observation;
  const auto stub = victim.server().NewStub<v1::ObserveService>();
  CheckTooLong(Ask(*stub, &v1::ObserveService::Stub::Represent, represent).status);

  // Two frames with an extremely long duration.
  for (const double rate : {1e-9, 1e-300, 5e-324}) {
    *recognize.mutable_observation() = victim.Markers(2, rate);
    CheckRefused(Ask(victim.query(), &v1::QueryService::Stub::Recognize, recognize).status,
                 "observation.markers");
  }
}

TEST_CASE("Hostile request: counts are limited by reserved memory", "[server][rpc][hostile]") {
  Victim victim;
  v1::EstimateRequest estimate;
  estimate.set_database("databases/db");
  *estimate.mutable_observation() = victim.Markers(kMaxFrames);
  estimate.set_max_candidates(0);
  estimate.set_path_count(100);
  const auto many_paths = Ask(victim.query(), &v1::QueryService::Stub::Estimate, estimate).status;
  CHECK(many_paths.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK_THAT(many_paths.error_message(), Contains("MiB of memory"));

  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  *recognize.mutable_observation() = victim.Markers(kMaxFrames);
  recognize.set_method(v1::METHOD_PAPER);
  recognize.set_whole(true);
  recognize.set_generation(v1::GENERATION_TOP_PATHS);
  recognize.set_path_count(100);
  const auto all_paths = Ask(victim.query(), &v1::QueryService::Stub::Recognize, recognize).status;
  CHECK(all_paths.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED);
  CHECK_THAT(all_paths.error_message(), Contains("MiB of memory"));

  v1::PlanRequest plan;
  plan.set_database("databases/db");
  plan.mutable_goal()->set_x_m(1);
  plan.set_frame_rate_hz(1000);
  plan.set_max_duration_seconds(120);
  plan.set_alternative_count(10);
  CheckRefused(Ask(victim.query(), &v1::QueryService::Stub::Plan, plan).status, "frame_rate_hz");
}

TEST_CASE("Hostile request: a robot of many joints is refused", "[server][rpc][hostile]") {
  Victim victim;
  v1::PlanRequest plan;
  plan.set_database("databases/db");
  plan.mutable_goal()->set_x_m(1);
  plan.mutable_robot()->set_file_name("chain.urdf");
  const auto refusal = [&](int joints, const char* type) {
    plan.mutable_robot()->set_urdf(ChainRobot(joints, type));
    const auto refused = Ask(victim.query(), &v1::QueryService::Stub::Plan, plan).status;
    CheckRefused(refused, "robot.urdf");
    return refused.error_message();
  };
  CHECK_THAT(refusal(1999, "continuous"), Contains("at most 300 degrees of freedom"));
  CHECK_THAT(refusal(1999, "fixed"), Contains("at most 1000 joints"));
  CHECK_THAT(refusal(20'000, "fixed"), Contains("at most 1999 joints"));
}

TEST_CASE("Hostile request: a prediction series without progress is refused",
          "[server][rpc][hostile]") {
  Victim victim;
  for (const double every : {1e-300, 1e-6, 0.5 / 60}) {
    v1::PredictSeriesRequest request;
    request.mutable_prediction()->set_database("databases/db");
    *request.mutable_prediction()->mutable_observation() = WalkObservation();
    request.set_every_seconds(every);
    grpc::ClientContext context;
    const auto reader = victim.query().PredictSeries(&context, request);
    v1::PredictSeriesResponse response;
    CHECK_FALSE(reader->Read(&response));
    CheckRefused(reader->Finish(), "every_seconds");
  }
}

TEST_CASE("Hostile request: a series that is not read ends with its client",
          "[server][rpc][hostile]") {
  Victim victim;
  v1::PredictSeriesRequest series;
  series.mutable_prediction()->set_database("databases/db");
  *series.mutable_prediction()->mutable_observation() = victim.Markers(20'000);
  series.set_every_seconds(1.0 / 60);
  grpc::ClientContext context;
  const auto reader = victim.query().PredictSeries(&context, series);
  v1::PredictSeriesResponse moment;
  REQUIRE(reader->Read(&moment));
  context.TryCancel();
  while (reader->Read(&moment)) {
  }
  CHECK(reader->Finish().error_code() == grpc::StatusCode::CANCELLED);
}

TEST_CASE("Hostile request: a client that does not read its series is disconnected",
          "[server][rpc][hostile]") {
  server::ServerOptions options = OneThread();
  options.calls.idle_limit = milliseconds(300);
  options.calls.heavy = {1, 1};
  Victim victim(options);
  v1::PredictSeriesRequest series;
  series.mutable_prediction()->set_database("databases/db");
  *series.mutable_prediction()->mutable_observation() = victim.Markers(2'500);
  series.set_every_seconds(1.0 / 60);
  // Large responses: the flow-control window has room for few of them.
  for (int h = 1; h <= 100; ++h) series.mutable_prediction()->add_horizon_seconds(0.01 * h);
  const auto stub = v1::QueryService::NewStub(victim.server().NewSmallChannel());
  grpc::ClientContext context;
  const auto reader = stub->PredictSeries(&context, series);
  v1::PredictSeriesResponse moment;
  REQUIRE(reader->Read(&moment));
  // Then its slot is free.
  *series.mutable_prediction()->mutable_observation() = WalkObservation();
  grpc::Status other;
  const auto latest = std::chrono::steady_clock::now() + std::chrono::seconds(180);
  do {
    std::this_thread::sleep_for(milliseconds(50));
    grpc::ClientContext asked;
    const auto moments = victim.query().PredictSeries(&asked, series);
    while (moments->Read(&moment)) {
    }
    other = moments->Finish();
  } while (other.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED &&
           std::chrono::steady_clock::now() < latest);
  CHECK(other.ok());
  while (reader->Read(&moment)) {
  }
  CHECK(reader->Finish().error_code() == grpc::StatusCode::CANCELLED);
}

TEST_CASE("Hostile request: too many joints are refused, in a query and in an ingest",
          "[server][rpc][hostile]") {
  TestServer server(OneThread());
  v1::CreateDatabaseRequest request;
  request.set_database_id("crowd");
  std::string set = "motiondb-marker-set 1\nname crowd\n";
  for (int m = 0; m < 300; ++m) set += fmt::format("marker m{}\n", m);
  request.mutable_database()->set_marker_set_file(set);
  const auto stub = server.NewStub<v1::DatabaseService>();
  CheckRefused(Ask(*stub, &v1::DatabaseService::Stub::CreateDatabase, request).status,
               "database.marker_set_file");

  server.CreateDatabase("db");
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name("crowd.bvh");
  CheckRefused(server.Ingest(header, ManyJointsFile(300)), "file_block");
  const grpc::Status too_many = server.Ingest(header, ManyJointsFile(250'000));
  CheckRefused(too_many, "file_block");
  CHECK_THAT(too_many.error_message(), Contains("crowd.bvh:") && Contains("at most 2000 joints"));
}

TEST_CASE("Hostile request: many joints with many frames are refused before kinematics",
          "[server][rpc][hostile]") {
  constexpr int kFrames = 140'000;
  server::ServerOptions options = OneThread();
  options.engine.max_frames = kFrames;
  Victim victim(options);
  const std::string file = ManyJointsFile(995, kFrames);  // 1995 joints with end sites
  const auto check = [](const grpc::Status& status, const std::string& field) {
    CheckRefused(status, field);
    CHECK_THAT(status.error_message(), Contains("140000 frames of 1995 joints"));
  };
  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  recognize.mutable_observation()->mutable_file()->set_file_name("crowd.bvh");
  recognize.mutable_observation()->mutable_file()->set_data(file);
  check(Ask(victim.query(), &v1::QueryService::Stub::Recognize, recognize).status,
        "observation.file");
  v1::RepresentRequest represent;
  represent.set_database("databases/db");
  *represent.mutable_observation() = recognize.observation();
  const auto stub = victim.server().NewStub<v1::ObserveService>();
  check(Ask(*stub, &v1::ObserveService::Stub::Represent, represent).status, "observation.file");
  v1::IngestClipHeader header;
  header.set_parent("databases/db");
  header.set_file_name("crowd.bvh");
  check(victim.server().Ingest(header, file), "file_block");
}

TEST_CASE("Hostile request: the work of a cancelled call ends", "[server][rpc][hostile]") {
  Victim victim;
  const v1::Observation minutes = victim.Markers(20'000);

  v1::EstimateRequest estimate;
  estimate.set_database("databases/db");
  *estimate.mutable_observation() = minutes;
  estimate.set_max_candidates(0);
  estimate.set_path_count(20);
  victim.EndsWithItsDeadline(&v1::QueryService::Stub::Estimate, estimate);

  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  *recognize.mutable_observation() = minutes;
  recognize.set_method(v1::METHOD_PAPER);
  recognize.set_generation(v1::GENERATION_TOP_PATHS);
  recognize.set_path_count(100);
  recognize.set_hop_seconds(1e-9);
  recognize.set_top_count(kAny);
  victim.EndsWithItsDeadline(&v1::QueryService::Stub::Recognize, recognize);

  v1::PredictRequest predict;
  predict.set_database("databases/db");
  *predict.mutable_observation() = minutes;
  predict.set_history_seconds(1e9);
  for (int h = 0; h < 1000; ++h) predict.add_horizon_seconds(3600 - h * 1e-3);
  predict.set_method(v1::METHOD_PAPER);
  victim.EndsWithItsDeadline(&v1::QueryService::Stub::Predict, predict);
}

}  // namespace
}  // namespace motiondb::tests::hostile_request_test
