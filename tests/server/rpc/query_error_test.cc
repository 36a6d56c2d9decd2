// Errors of QueryService: no model, invalid options and observations, a deadline.
#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/refusal.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/packed_floats.h"
#include "tests/support/stick_figure.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::query_error_test {
namespace {

using Stub = v1::QueryService::Stub;

const double kNan = std::numeric_limits<double>::quiet_NaN();

TEST_CASE("QueryService: the error of a database without a model tells what to do",
          "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  const auto answer = Ask(*stub, &Stub::Recognize, RequestFor<v1::RecognizeRequest>("empty"));
  CHECK(answer.status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(answer.status.error_message() ==
        "database 'empty' has no model yet: ingest clips first (motiondb ingest empty FILE...)");
  CHECK(Ask(*stub, &Stub::Estimate, RequestFor<v1::EstimateRequest>("none")).status.error_code() ==
        grpc::StatusCode::NOT_FOUND);

  TestServer building;
  building.CreateDatabase("db");
  building.gate().Close();
  building.IngestFigure("db", "walk", "walk", {});
  const auto other = building.NewStub<v1::QueryService>();
  const auto early = Ask(*other, &Stub::Predict, RequestFor<v1::PredictRequest>("db"));
  CHECK(early.status.error_code() == grpc::StatusCode::FAILED_PRECONDITION);
  CHECK(early.status.error_message().find("wait for operations/") != std::string::npos);
  CHECK(ReasonOf(early.status) == "MODEL_BUILDING");
  CHECK(ReasonOf(answer.status) == "NO_MODEL");
  CHECK(ReasonOf(Ask(*stub, &Stub::Estimate, RequestFor<v1::EstimateRequest>("none")).status) ==
        "DATABASE_NOT_FOUND");
}

TEST_CASE("QueryService: the error names the invalid option", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  const auto recognize = [&](const std::string& field, const auto& change) {
    auto request = RequestFor<v1::RecognizeRequest>("db");
    change(request);
    const auto answer = Ask(*stub, &Stub::Recognize, request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(ViolatedFields(answer.status) == field);
  };
  recognize("database", [](auto& r) { r.set_database("db"); });
  recognize("window_seconds", [](auto& r) { r.set_window_seconds(kNan); });
  recognize("window_seconds", [](auto& r) { r.set_window_seconds(-1); });
  recognize("hop_seconds", [](auto& r) { r.set_hop_seconds(-0.1); });
  recognize("hop_seconds", [](auto& r) { r.set_hop_seconds(0); });
  recognize("layer", [](auto& r) { r.set_layer(-1); });
  recognize("layer", [](auto& r) { r.set_layer(0); });
  recognize("layer", [](auto& r) { r.set_layer(1000); });
  recognize("top_count", [](auto& r) { r.set_top_count(0); });
  recognize("transition_floor", [](auto& r) { r.set_transition_floor(2); });
  recognize("transition_floor", [](auto& r) { r.set_transition_floor(kNan); });
  recognize("generation", [](auto& r) { r.set_generation(static_cast<v1::Generation>(7)); });
  recognize("path_count", [](auto& r) { r.set_path_count(-1); });
  recognize("method", [](auto& r) { r.set_method(static_cast<v1::Method>(7)); });
  recognize("observation", [](auto& r) { r.clear_observation(); });

  const auto estimate = [&](const std::string& field, const auto& change) {
    auto request = RequestFor<v1::EstimateRequest>("db");
    change(request);
    CHECK(ViolatedFields(Ask(*stub, &Stub::Estimate, request).status) == field);
  };
  estimate("path_count", [](auto& r) { r.set_path_count(101); });
  estimate("max_candidates", [](auto& r) { r.set_max_candidates(-1); });

  const auto predict = [&](const std::string& field, const auto& change) {
    auto request = RequestFor<v1::PredictRequest>("db");
    change(request);
    CHECK(ViolatedFields(Ask(*stub, &Stub::Predict, request).status) == field);
  };
  predict("at_seconds", [](auto& r) { r.set_at_seconds(-1); });
  predict("method", [](auto& r) { r.set_method(static_cast<v1::Method>(7)); });
  predict("history_seconds", [](auto& r) { r.set_history_seconds(kNan); });
  predict("horizon_seconds[0]", [](auto& r) { r.add_horizon_seconds(-0.1); });

  const auto find = [&](const std::string& field, const auto& change) {
    auto request = RequestFor<v1::FindRequest>("db");
    change(request);
    const auto answer = Ask(*stub, &Stub::Find, request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(ViolatedFields(answer.status) == field);
  };
  const auto of_clip = [](auto& r) { r.mutable_clip_range()->set_clip("databases/db/clips/walk"); };
  find("top_count", [](auto& r) { r.set_top_count(0); });
  find("top_count", [](auto& r) { r.set_top_count(1001); });
  find("start_seconds", [](auto& r) { r.set_start_seconds(kNan); });
  find("start_seconds", [](auto& r) { r.set_start_seconds(0.9); });
  find("end_seconds", [](auto& r) { r.set_end_seconds(0.9); });
  find("observation", [](auto& r) { r.clear_observation(); });
  find("filter", [](auto& r) { r.set_filter("label ="); });
  find("clip_range.clip", [](auto& r) { r.mutable_clip_range()->set_clip("walk"); });
  find("clip_range.clip", [](auto& r) { r.mutable_clip_range()->set_clip("databases/a/clips/b"); });
  find("clip_range.clip",
       [](auto& r) { r.mutable_clip_range()->set_clip("databases/db/clips/no"); });
  find("clip_range.end_seconds", [&](auto& r) {
    of_clip(r);
    r.mutable_clip_range()->set_end_seconds(0);
  });
  find("clip_range.start_seconds", [&](auto& r) {
    of_clip(r);
    r.mutable_clip_range()->set_start_seconds(-1);
  });
  find("end_seconds", [&](auto& r) {
    of_clip(r);
    r.set_end_seconds(1);
  });
  v1::FindRequest absent;
  absent.set_database("databases/db");
  absent.mutable_clip_range()->set_clip("databases/db/clips/no");
  CHECK(ReasonOf(Ask(*stub, &Stub::Find, absent).status) == "CLIP_NOT_FOUND");

  v1::PredictSeriesRequest series;
  *series.mutable_prediction() = RequestFor<v1::PredictRequest>("db");
  const auto series_fields = [&] {
    grpc::ClientContext context;
    const auto reader = stub->PredictSeries(&context, series);
    v1::PredictSeriesResponse moment;
    while (reader->Read(&moment)) {
    }
    return ViolatedFields(reader->Finish());
  };
  CHECK(series_fields() == "every_seconds");
  series.set_every_seconds(kNan);
  CHECK(series_fields() == "every_seconds");
  series.set_every_seconds(0.1);
  series.mutable_prediction()->set_layer(-3);
  CHECK(series_fields() == "prediction.layer");
  series.mutable_prediction()->clear_layer();
  series.mutable_prediction()->clear_observation();
  CHECK(series_fields() == "prediction.observation");
}

TEST_CASE("QueryService: the error names the invalid observation", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  const auto expect = [&](const std::string& field, const v1::Observation& observation) {
    v1::EstimateRequest request;
    request.set_database("databases/db");
    *request.mutable_observation() = observation;
    const auto answer = Ask(*stub, &Stub::Estimate, request);
    INFO(field << ": " << answer.status.error_message());
    CHECK(answer.status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(answer.status) == field);
  };
  const auto file = [&](const std::string& field, const auto& change) {
    v1::Observation observation = WalkObservation();
    change(*observation.mutable_file());
    expect("observation.file." + field, observation);
  };
  file("file_name", [](auto& f) { f.clear_file_name(); });
  file("file_name", [](auto& f) { f.set_file_name("a.xyz"); });
  file("data", [](auto& f) { f.set_data("nonsense"); });
  file("skeleton_file_name", [](auto& f) { f.set_format(v1::FILE_FORMAT_AMC); });
  file("conventions.leg_length_m",
       [](auto& f) { f.mutable_conventions()->set_leg_length_m(kNan); });

  const auto markers = [&](const std::string& field, const auto& change) {
    v1::Observation observation;
    v1::MarkerObservation& m = *observation.mutable_markers();
    m.set_frame_rate_hz(60);
    m.set_frame_count(10);
    m.set_positions(Pack(std::vector<float>(10 * 30, 1.0F)));
    change(m);
    expect("observation.markers" + field, observation);
  };
  markers(".frame_rate_hz", [](auto& m) { m.set_frame_rate_hz(0); });
  markers(".frame_rate_hz", [](auto& m) { m.set_frame_rate_hz(kNan); });
  markers(".frame_count", [](auto& m) { m.set_frame_count(0); });
  markers(".positions", [](auto& m) { m.mutable_positions()->pop_back(); });
  markers(".positions", [](auto& m) { m.set_frame_count(1'000'000); });
  markers(".positions", [](auto& m) {
    m.set_positions(Pack(std::vector<float>(300, std::numeric_limits<float>::infinity())));
  });
  markers(".marker_names", [](auto& m) {
    m.add_marker_names("A");
    m.add_marker_names("A");
  });
  markers(".leg_length_m", [](auto& m) { m.set_leg_length_m(-1); });
  markers("", [](auto& m) {  // no markers that the database can use
    for (int i = 0; i < 10; ++i) m.add_marker_names(std::string(1, static_cast<char>('a' + i)));
  });

  v1::Observation joints;
  joints.mutable_joints()->set_skeleton("databases/other/skeletons/Hips");
  expect("observation.joints.skeleton", joints);
  joints.mutable_joints()->set_skeleton("Hips");
  expect("observation.joints.skeleton", joints);
}

TEST_CASE("QueryService: joint angles in degrees are refused", "[server][rpc]") {
  constexpr int kFrames = 30;
  constexpr int kRotations = 30;  // of the figure, after three translations
  const auto clips = TrainedServer().NewStub<v1::ClipService>();
  v1::ListSkeletonsRequest list;
  list.set_parent("databases/db");
  const auto skeleton =
      Ask(*clips, &v1::ClipService::Stub::ListSkeletons, list).response.skeletons(0);
  REQUIRE(skeleton.dof_count() == 3 + kRotations);
  // Recognizes a motion in which the last `columns` of the angles are `angle` in the last `frames`
  // frames, and the translations are `translation`; all other numbers are 0.
  const auto recognize = [&](float angle, int columns, int frames, float translation = 0) {
    auto request = RequestFor<v1::RecognizeRequest>("db");
    v1::JointObservation& joints = *request.mutable_observation()->mutable_joints();
    joints.set_skeleton(skeleton.name());
    joints.set_frame_rate_hz(60);
    joints.set_frame_count(kFrames);
    std::vector<float> angles;
    for (int frame = 0; frame < kFrames; ++frame) {
      angles.insert(angles.end(), 3, translation);
      const int large = frame < kFrames - frames ? 0 : columns;
      angles.insert(angles.end(), static_cast<std::size_t>(kRotations - large), 0.0F);
      angles.insert(angles.end(), static_cast<std::size_t>(large), angle);
    }
    joints.set_angles(Pack(angles));
    const auto stub = TrainedServer().NewStub<v1::QueryService>();
    return Ask(*stub, &Stub::Recognize, request).status;
  };
  for (const float degrees : {40.0F, -40.0F}) {
    const grpc::Status refused = recognize(degrees, 6, 16);
    CHECK(refused.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(refused) == "observation.joints.angles");
    CHECK(refused.error_message().find("expected radians; 6 of 30 rotations") != std::string::npos);
  }
  const auto is_accepted = [&](float angle, int columns, int frames, float translation = 0) {
    const grpc::Status status = recognize(angle, columns, frames, translation);
    INFO(status.error_message());
    CHECK(status.ok());
  };
  is_accepted(40, 6, 15);       // half of the frames
  is_accepted(40, 5, kFrames);  // less than a fifth of the rotations
  is_accepted(6.2F, 9, kFrames);
  is_accepted(40, 5, kFrames, 40);  // a translation is no angle
}

TEST_CASE("QueryService: a deadline stops the work", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::EstimateRequest>("db");
  request.mutable_observation()->mutable_file()->set_data(WriteBvh({.frame_count = 20'000}));
  request.set_max_candidates(0);
  request.set_path_count(10);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(50));
  v1::EstimateResponse response;
  CHECK(stub->Estimate(&context, request, &response).error_code() ==
        grpc::StatusCode::DEADLINE_EXCEEDED);
}

}  // namespace
}  // namespace motiondb::tests::query_error_test
