// motiondb picture: options, requests and files.
#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/query.pb.h>
#include <motiondb/v1/view.pb.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/client/fake_server.h"
#include "tests/client/planned_motion.h"
#include "tests/client/plot/png_pixels.h"
#include "tests/client/plot/recognition_answers.h"
#include "tests/client/plot/state_map_messages.h"
#include "tests/client/plot/svg_elements.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::picture_command_test {
namespace {

using Catch::Contains;

// A server that answers every call of a picture.
void AnswerEverything(FakeServer& server) {
  server.Answer("ReadStateMap", MapHeader(), MapNodes(), MapTransitions(), MapPoints());
  v1::GetFigureResponse figure;
  *figure.mutable_figure() = TwoMarkers();
  server.Answer("GetFigure", figure);
  v1::GetNodePosesResponse poses;
  for (int id = 4; id < 8; ++id) {
    v1::NodePose& pose = *poses.add_poses();
    pose.set_node_id(id);
    pose.set_marker_positions(Pack(TwoMarkerPose(0)));
    pose.set_marker_velocities(Pack(TwoMarkerPose(1)));
  }
  server.Answer("GetNodePoses", poses);
  v1::ReadClipMotionResponse motion;
  motion.set_frame_rate_hz(10);
  motion.set_clip_frame_count(3);
  motion.set_frame_count(1);
  motion.set_marker_positions(Pack(TwoMarkerPose(0)));
  server.Answer("ReadClipMotion", motion);
  std::vector<float> frames;
  for (int i = 0; i < 3; ++i) {
    const std::vector<float> pose = TwoMarkerPose(static_cast<float>(i));
    frames.insert(frames.end(), pose.begin(), pose.end());
  }
  v1::PredictResponse prediction;
  prediction.set_at_seconds(0.1);
  prediction.set_layer(3);
  for (const int id : {7, 4, 5, 6}) prediction.add_next_nodes()->set_node_id(id);
  server.Answer("Predict", prediction);
  v1::EstimateResponse estimate;
  estimate.set_frame_rate_hz(10);
  v1::NodePath& path = *estimate.add_paths();
  for (const int id : {4, 6, 5}) path.add_node_ids(id);
  server.Answer("Estimate", estimate);
  v1::RepresentResponse represented;
  represented.mutable_markers()->set_frame_rate_hz(10);
  represented.mutable_markers()->set_frame_count(3);
  represented.mutable_markers()->set_positions(Pack(frames));
  server.Answer("Represent", represented);
  server.Answer("Recognize", WalkThenJog(3));
  server.Answer("Plan", QuarterCirclePlan());
}

TEST_CASE("motiondb picture: every picture as SVG and PNG", "[client][cli]") {
  FakeServer server;
  AnswerEverything(server);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const std::vector<std::vector<std::string>> pictures = {
      {"map", "walks"},
      {"map", "walks", "--axes", "1,2,3", "--colour", "clip", "--width", "500", "--height", "450"},
      {"layer", "walks", "--layer", "3"},
      {"clip", "walks", "07_01"},
      {"estimate", "walks", file, "--at", "0.1"},
      {"recognize", "walks", file, "--layers", "3,2"},
      {"plan", "walks", "--goal", "1,1,90deg"},
  };
  for (const std::vector<std::string>& picture : pictures) {
    for (const std::string extension : {".svg", ".png"}) {
      const std::string out = (folder / ("picture" + extension)).string();
      std::vector<std::string> arguments = {"picture"};
      arguments.insert(arguments.end(), picture.begin(), picture.end());
      arguments.insert(arguments.end(), {"--out", out});
      const auto result = RunMotiondb(server.address(), arguments);
      CAPTURE(picture, result.err);
      CHECK(result.exit_code == 0);
      CHECK(result.out == "wrote " + out + "\n");
      const std::string bytes = ReadFile(out);
      if (extension == ".svg") {
        CHECK(!ElementsInGroups(bytes).empty());
      } else {
        CHECK(PngPixels(bytes).ColourCount() > 10);
      }
      REQUIRE(RunMotiondb(server.address(), arguments).exit_code == 0);
      CHECK(ReadFile(out) == bytes);
    }
  }
}

TEST_CASE("motiondb picture: requests", "[client][cli]") {
  FakeServer server;
  AnswerEverything(server);
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const std::string out = (folder / "a.png").string();
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "picture");
    arguments.insert(arguments.end(), {"--out", out});
    const auto result = RunMotiondb(server.address(), arguments);
    INFO(result.err);
    CHECK(result.exit_code == 0);
  };
  run({"map", "walks", "--points", "7", "--width", "640", "--height", "480"});
  const PngPixels pixels(ReadFile(out));
  CHECK(pixels.width() == 640);
  CHECK(pixels.height() == 480);
  auto maps = server.Requests<v1::ReadStateMapRequest>("ReadStateMap");
  REQUIRE(maps.size() == 1);
  CHECK(maps[0].parent() == "databases/walks/models/current");
  CHECK(maps[0].max_points() == 7);
  CHECK(!maps[0].has_layer());
  auto poses = server.Requests<v1::GetNodePosesRequest>("GetNodePoses");
  REQUIRE(poses.size() == 1);
  CHECK(poses[0].layer() == 3);
  CHECK(std::vector<int>(poses[0].node_ids().begin(), poses[0].node_ids().end()) ==
        std::vector<int>{4, 5, 6, 7});

  run({"clip", "walks", "07_01", "--layer", "2", "--poses", "3"});
  maps = server.Requests<v1::ReadStateMapRequest>("ReadStateMap");
  REQUIRE(maps.size() == 3);
  CHECK(maps[1].clip().empty());
  CHECK(maps[2].clip() == "databases/walks/clips/07_01");
  CHECK(maps[2].layer() == 2);
  const auto motions = server.Requests<v1::ReadClipMotionRequest>("ReadClipMotion");
  REQUIRE(motions.size() == 3);
  for (int i = 0; i < 3; ++i) {
    CHECK(motions[static_cast<std::size_t>(i)].first_frame() == i);
    CHECK(motions[static_cast<std::size_t>(i)].frame_count() == 1);
  }

  run({"recognize", "walks", file, "--layers", "3,2", "--window", "0.5"});
  const auto recognized = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(recognized.size() == 2);
  CHECK(recognized[0].layer() == 3);
  CHECK(recognized[1].layer() == 2);
  CHECK(recognized[1].method() == v1::METHOD_PAPER);
  CHECK(recognized[1].window_seconds() == 0.5);
}

TEST_CASE("motiondb picture: errors name the option and leave no file", "[client][cli]") {
  FakeServer server;
  server.Fail("ReadStateMap", 9, "database walks has no model");
  const TemporaryFolder folder;
  const auto refused = [&](int code, const std::string& expected,
                           const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {"picture"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const auto result = RunMotiondb(server.address(), command);
    CAPTURE(arguments);
    CHECK(result.exit_code == code);
    CHECK_THAT(result.err, Contains(expected));
  };
  const std::string out = (folder / "a.svg").string();
  refused(2, "--out", {"map", "walks"});
  refused(2, "--out a.pdf: expected FILE.svg or FILE.png", {"map", "walks", "--out", "a.pdf"});
  for (const std::string axes : {"1", "1,1", "0,1", "1,4", "1,2,3,1", "1.5,2", "x"}) {
    refused(2, "two or three different axes", {"map", "walks", "--axes", axes, "--out", out});
  }
  refused(2, "--width", {"map", "walks", "--width", "10", "--out", out});
  refused(2, "--colour", {"map", "walks", "--colour", "age", "--out", out});
  refused(2, "--layer", {"layer", "walks", "--layer", "0", "--out", out});
  refused(2, "--layers", {"recognize", "walks", "a.bvh", "--layers", "0", "--out", out});
  refused(2, "CLIP", {"clip", "walks", "--out", out});
  refused(1, "none", {"map", "walks", "--out", (folder / "none/a.svg").string()});
  refused(1, "database walks has no model", {"map", "walks", "--out", out});
  CHECK(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace motiondb::tests::picture_command_test
