// Responses of QueryService, over a real socket.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/query.grpc.pb.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/packed_floats.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::query_service_test {
namespace {

using Stub = v1::QueryService::Stub;

TEST_CASE("QueryService: recognizes a walk", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::RecognizeRequest>("db");
  const auto answer = Ask(*stub, &Stub::Recognize, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  REQUIRE(answer.response.windows_size() > 2);
  for (const v1::RecognitionWindow& window : answer.response.windows()) {
    CHECK(window.end_seconds() - window.start_seconds() == Approx(0.4).margin(0.02));
    REQUIRE(window.labels_size() == 3);
    CHECK(window.labels(0).label() == "walk");
    double sum = 0;
    for (const auto& label : window.labels()) sum += label.probability();
    CHECK(sum == Approx(1));
    REQUIRE(window.clips_size() == 3);
    CHECK(window.clips(0).clip() == "databases/db/clips/walk");
  }
  request.set_method(v1::METHOD_PAPER);
  const auto by_paper = Ask(*stub, &Stub::Recognize, request);
  for (const v1::RecognitionWindow& window : by_paper.response.windows()) {
    REQUIRE(window.clips_size() == 3);
    CHECK(window.clips(0).log_probability() >= window.clips(1).log_probability());
  }
  request.clear_method();
  request.set_whole(true);
  request.set_top_count(1);
  const auto whole = Ask(*stub, &Stub::Recognize, request);
  REQUIRE(whole.response.windows_size() == 1);
  CHECK(whole.response.windows(0).clips_size() == 1);
}

TEST_CASE("QueryService: finds similar parts of clips", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::FindRequest>("db");
  const auto observed = Ask(*stub, &Stub::Find, request);
  INFO(observed.status.error_message());
  REQUIRE(observed.status.ok());
  CHECK(observed.response.model_version() == 1);
  REQUIRE(observed.response.matches_size() >= 3);
  CHECK(observed.response.matches_size() <= 10);
  CHECK(observed.response.matches(0).clip() == "databases/db/clips/walk");
  for (int i = 1; i < observed.response.matches_size(); ++i) {
    CHECK(observed.response.matches(i).score() <= observed.response.matches(i - 1).score());
    CHECK(observed.response.matches(i).end_seconds() >
          observed.response.matches(i).start_seconds());
  }

  request.Clear();
  request.set_database("databases/db");
  request.mutable_clip_range()->set_clip("databases/db/clips/squat");
  request.mutable_clip_range()->set_start_seconds(0.5);
  request.mutable_clip_range()->set_end_seconds(1.25);
  request.set_top_count(2);
  const auto own = Ask(*stub, &Stub::Find, request);
  REQUIRE(own.response.matches_size() == 2);
  CHECK(own.response.matches(0).clip() == "databases/db/clips/squat");
  CHECK(own.response.matches(0).start_seconds() == Approx(0.5));
  CHECK(own.response.matches(0).end_seconds() == Approx(1.25));
  CHECK(own.response.matches(0).score() == Approx(1).margin(1e-3));
  request.set_exhaustive(true);
  CHECK(Ask(*stub, &Stub::Find, request).response.SerializeAsString() ==
        own.response.SerializeAsString());

  request.set_filter("label != \"squat\"");
  request.set_top_count(100);
  const auto others = Ask(*stub, &Stub::Find, request);
  REQUIRE(others.response.matches_size() >= 2);
  for (const v1::FindMatch& match : others.response.matches()) {
    CHECK(match.clip() != "databases/db/clips/squat");
  }
  request.set_filter("label = \"none\"");
  CHECK(Ask(*stub, &Stub::Find, request).status.error_code() ==
        grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_CASE("QueryService: estimates node paths", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::EstimateRequest>("db");
  request.set_path_count(3);
  const auto answer = Ask(*stub, &Stub::Estimate, request);
  INFO(answer.status.error_message());
  REQUIRE(answer.status.ok());
  REQUIRE(answer.response.paths_size() >= 1);
  CHECK(answer.response.paths(0).node_ids_size() == 48);
  CHECK(answer.response.frame_rate_hz() == 60);
  CHECK(answer.response.state().node_id() == answer.response.paths(0).node_ids(47));
  for (int i = 1; i < answer.response.paths_size(); ++i) {
    CHECK(answer.response.paths(i - 1).log_probability() >=
          answer.response.paths(i).log_probability());
  }
}

TEST_CASE("QueryService: predicts, and a series has the same predictions", "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::PredictRequest>("db");
  const auto at_end = Ask(*stub, &Stub::Predict, request);
  INFO(at_end.status.error_message());
  REQUIRE(at_end.status.ok());
  CHECK(at_end.response.at_seconds() == Approx(47 / 60.0));
  REQUIRE(at_end.response.horizons_size() == 6);
  CHECK(at_end.response.horizons(0).seconds() == Approx(0.08));
  CHECK(at_end.response.horizons(0).marker_count() == 10);

  v1::PredictSeriesRequest series;
  *series.mutable_prediction() = request;
  series.set_every_seconds(0.1);
  grpc::ClientContext context;
  const auto reader = stub->PredictSeries(&context, series);
  v1::PredictSeriesResponse moment;
  std::vector<v1::PredictResponse> moments;
  while (reader->Read(&moment)) moments.push_back(moment.prediction());
  REQUIRE(reader->Finish().ok());
  REQUIRE(moments.size() == 4);  // 0.4, 0.5, 0.6, 0.7 of 0.783 s
  for (std::size_t i = 0; i < moments.size(); ++i) {
    request.set_at_seconds(0.4 + 0.1 * static_cast<double>(i));
    const auto single = Ask(*stub, &Stub::Predict, request);
    CHECK(single.response.SerializeAsString() == moments[i].SerializeAsString());
  }
}

// Returns the BVH file with its root moved by `metres` along the first axis.
std::string WithShiftedRoot(const std::string& bvh, double metres) {
  std::istringstream lines(bvh);
  std::string moved;
  bool in_frames = false;
  for (std::string line; std::getline(lines, line); moved += '\n') {
    if (!in_frames) {
      moved += line;
      in_frames = line.starts_with("Frame Time:");
      continue;
    }
    std::size_t read = 0;
    const double centimetres = std::stod(line, &read) + 100 * metres;
    moved += std::to_string(centimetres) + line.substr(read);
  }
  return moved;
}

// Regression: such a prediction had an error of 1e8 m.
TEST_CASE("QueryService: a motion 90 km away has the same prediction as at the origin",
          "[server][rpc]") {
  const auto stub = TrainedServer().NewStub<v1::QueryService>();
  auto request = RequestFor<v1::PredictRequest>("db");
  for (const v1::Method method : {v1::METHOD_BEST, v1::METHOD_PAPER}) {
    request.set_method(method);
    std::string& file = *request.mutable_observation()->mutable_file()->mutable_data();
    file = WithShiftedRoot(file, 0);
    const auto here = Ask(*stub, &Stub::Predict, request);
    file = WithShiftedRoot(file, 90'000);
    const auto there = Ask(*stub, &Stub::Predict, request);
    INFO(there.status.error_message());
    REQUIRE(here.status.ok());
    REQUIRE(there.status.ok());
    REQUIRE(there.response.horizons_size() == here.response.horizons_size());
    for (int h = 0; h < here.response.horizons_size(); ++h) {
      const auto near = Unpack(here.response.horizons(h).marker_positions());
      const auto far = Unpack(there.response.horizons(h).marker_positions());
      REQUIRE(near.size() > 0);
      REQUIRE(far.size() == near.size());
      double max_deviation = 0;  // maximum deviation of a marker from the common shift, m
      double distance = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double step = far[axis] - near[axis];
        distance += step * step;
        for (std::size_t i = axis; i < near.size(); i += 3) {
          max_deviation = std::max(max_deviation, std::abs(far[i] - near[i] - step));
        }
      }
      CHECK(std::sqrt(distance) == Approx(90'000).margin(0.05));
      CHECK(max_deviation < 0.05);  // a float has a resolution of 8 mm there
    }
    file = WithShiftedRoot(file, -90'000);
  }
}

TEST_CASE("QueryService: markers and joints are observations like files", "[server][rpc]") {
  TestServer& server = TrainedServer();
  const auto stub = server.NewStub<v1::QueryService>();
  // A prediction for "now" returns marker positions: use them as an observation.
  auto request = RequestFor<v1::PredictRequest>("db");
  request.clear_horizon_seconds();
  v1::MarkerObservation markers;
  markers.set_frame_rate_hz(60);
  for (int frame = 0; frame < 40; ++frame) {
    request.set_at_seconds(frame / 60.0);
    request.clear_horizon_seconds();
    request.add_horizon_seconds(0.08);
    const auto answer = Ask(*stub, &Stub::Predict, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    markers.mutable_positions()->append(answer.response.horizons(0).marker_positions());
  }
  markers.set_frame_count(40);
  v1::RecognizeRequest recognize;
  recognize.set_database("databases/db");
  *recognize.mutable_observation()->mutable_markers() = markers;
  const auto by_markers = Ask(*stub, &Stub::Recognize, recognize);
  INFO(by_markers.status.error_message());
  REQUIRE(by_markers.status.ok());
  CHECK(by_markers.response.windows(0).labels(0).label() == "walk");

  // A missing marker is filled in.
  const std::size_t markers_seen = markers.positions().size() / (40 * 3 * sizeof(float));
  REQUIRE(markers_seen == 10);
  const std::string missing = Pack({std::nanf(""), std::nanf(""), std::nanf("")});
  for (std::size_t frame = 30; frame < 40; ++frame) {
    markers.mutable_positions()->replace((frame * 10 + 9) * missing.size(), missing.size(),
                                         missing);
  }
  v1::EstimateRequest estimate;
  estimate.set_database("databases/db");
  *estimate.mutable_observation()->mutable_markers() = markers;
  const auto last = Ask(*stub, &Stub::Estimate, estimate);
  INFO(last.status.error_message());
  REQUIRE(last.response.filled_frames_size() == 1);
  const v1::FilledFrame& filled = last.response.filled_frames(0);
  CHECK(filled.frame() == 39);
  CHECK(filled.seconds() == Approx(39 / 60.0));
  CHECK(filled.marker_count() == 10);
  const std::vector<float> positions = Unpack(filled.marker_positions());
  const std::vector<float> deviations = Unpack(filled.marker_deviations());
  REQUIRE(positions.size() == 30);
  REQUIRE(deviations.size() == 10);
  CHECK(deviations[8] == 0);
  CHECK(deviations[9] > 0);
  CHECK(std::isfinite(positions[29]));
  estimate.set_fill_every_frame(true);
  CHECK(Ask(*stub, &Stub::Estimate, estimate).response.filled_frames_size() == 10);

  const auto clips = server.NewStub<v1::ClipService>();
  v1::ListSkeletonsRequest list;
  list.set_parent("databases/db");
  const auto skeleton =
      Ask(*clips, &v1::ClipService::Stub::ListSkeletons, list).response.skeletons(0);
  v1::JointObservation joints;
  joints.set_skeleton(skeleton.name());
  joints.set_frame_rate_hz(60);
  joints.set_frame_count(30);
  joints.set_angles(Pack(std::vector<float>(30 * skeleton.dof_count(), 0.0F)));
  *recognize.mutable_observation()->mutable_joints() = joints;
  const auto by_joints = Ask(*stub, &Stub::Recognize, recognize);
  INFO(by_joints.status.error_message());
  CHECK(by_joints.status.ok());
}

}  // namespace
}  // namespace motiondb::tests::query_service_test
