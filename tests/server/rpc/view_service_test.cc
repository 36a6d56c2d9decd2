// Figures, motion of clips and poses of nodes.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/format/motion_file.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"
#include "core/view/model_picture.h"
#include "motiondb/v1/access.grpc.pb.h"
#include "motiondb/v1/database.grpc.pb.h"
#include "motiondb/v1/view.grpc.pb.h"
#include "server/engine/live_database.h"
#include "server/engine/model_lifecycle.h"
#include "tests/server/rpc/limited_server.h"
#include "tests/server/rpc/trained_server.h"
#include "tests/support/packed_floats.h"

namespace motiondb::tests::view_service_test {
namespace {

using Stub = v1::ViewService::Stub;
using grpc::StatusCode;

constexpr char kCurrent[] = "databases/db/models/current";
constexpr char kWalk[] = "databases/db/clips/walk";

grpc::Status FigureOf(TestServer& server, const std::string& name, v1::Figure* figure = nullptr) {
  v1::GetFigureRequest request;
  request.set_name(name);
  const auto answer = Ask(*server.NewStub<v1::ViewService>(), &Stub::GetFigure, request);
  if (figure != nullptr) *figure = answer.response.figure();
  return answer.status;
}

struct Motion {
  grpc::Status status;
  std::vector<v1::ReadClipMotionResponse> blocks;
  std::vector<float> markers;
  std::vector<float> joints;
  std::string contacts;
};

Motion ReadMotion(TestServer& server, const v1::ReadClipMotionRequest& request) {
  Motion motion;
  grpc::ClientContext context;
  const auto stub = server.NewStub<v1::ViewService>();
  const auto reader = stub->ReadClipMotion(&context, request);
  v1::ReadClipMotionResponse block;
  while (reader->Read(&block)) {
    CHECK(block.ByteSizeLong() <= 1 << 20);
    const auto append = [](const std::string& bytes, std::vector<float>& to) {
      const std::vector<float> values = Unpack(bytes);
      to.insert(to.end(), values.begin(), values.end());
    };
    append(block.marker_positions(), motion.markers);
    append(block.joint_positions(), motion.joints);
    motion.contacts += block.contacts();
    motion.blocks.push_back(block);
  }
  motion.status = reader->Finish();
  return motion;
}

v1::ReadClipMotionRequest MotionRequest(const std::string& name) {
  v1::ReadClipMotionRequest request;
  request.set_name(name);
  return request;
}

int IndexOf(const std::string& name, const google::protobuf::RepeatedPtrField<std::string>& names) {
  return static_cast<int>(std::ranges::find(names, name) - names.begin());
}

TEST_CASE("GetFigure: markers of joints have the bones of the skeleton", "[server][view]") {
  TestServer& server = TrainedServer();
  v1::Figure database;
  REQUIRE(FigureOf(server, "databases/db", &database).ok());
  CHECK(database.marker_names_size() == 10);
  CHECK(database.marker_bones_size() == 9);
  CHECK(database.joint_names().empty());
  v1::Figure clip;
  REQUIRE(FigureOf(server, kWalk, &clip).ok());
  CHECK(clip.joint_bones_size() == clip.joint_names_size() - 1);
  REQUIRE(clip.marker_bones_size() == database.marker_bones_size());
  for (int i = 0; i < clip.marker_bones_size(); ++i) {
    CHECK(clip.marker_bones(i).SerializeAsString() == database.marker_bones(i).SerializeAsString());
    // A bone of the markers is one of the skeleton, or skips joints without a marker.
    const v1::Bone& bone = clip.marker_bones(i);
    CHECK(IndexOf(clip.marker_names(bone.from_point()), clip.joint_names()) <
          IndexOf(clip.marker_names(bone.to_point()), clip.joint_names()));
  }
}

TEST_CASE("GetFigure: errors", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto code = [&](const char* name) { return FigureOf(server, name).error_code(); };
  CHECK(code("databases/none") == StatusCode::NOT_FOUND);
  CHECK(code("databases/db/clips/none") == StatusCode::NOT_FOUND);
  CHECK(code("databases/none/clips/walk") == StatusCode::NOT_FOUND);
  CHECK(code("databases/empty") == StatusCode::FAILED_PRECONDITION);
  for (const char* name :
       {"", "db", "databases/", "databases/db/models/1", "databases/db/clips/"}) {
    INFO(name);
    const grpc::Status status = FigureOf(server, name);
    CHECK(status.error_code() == StatusCode::INVALID_ARGUMENT);
    CHECK(ViolatedFields(status) == "name");
  }
}

TEST_CASE("ReadClipMotion: markers and joints in the world", "[server][view]") {
  TestServer& server = TrainedServer();
  auto request = MotionRequest(kWalk);
  request.set_joints(true);
  const Motion motion = ReadMotion(server, request);
  INFO(motion.status.error_message());
  REQUIRE(motion.status.ok());
  REQUIRE(motion.blocks.size() == 1);
  const v1::ReadClipMotionResponse& first = motion.blocks[0];
  CHECK(first.frame_rate_hz() == 60);
  CHECK(first.clip_frame_count() == 120);
  CHECK(first.first_frame() == 0);
  CHECK(first.frame_count() == 120);
  CHECK(motion.contacts.size() == 120);
  const auto& names = first.figure().marker_names();
  const auto& joint_names = first.figure().joint_names();
  REQUIRE(motion.markers.size() == 120u * 3 * static_cast<std::size_t>(names.size()));
  REQUIRE(motion.joints.size() == 120u * 3 * static_cast<std::size_t>(joint_names.size()));
  // The file itself, by forward kinematics; its floor may be at another height.
  const std::string bytes = WriteBvh({.act = Act::kWalk, .frame_count = 120});
  const auto file = core::ReadMotionFile(core::FileFormat::kBvh, {"walk.bvh", bytes});
  REQUIRE(file.ok());
  const core::FrameMatrix expected =
      core::JointPositions(std::get<core::JointMotion>(file->motion));
  REQUIRE(expected.size() == static_cast<Eigen::Index>(motion.joints.size()));
  const Eigen::Map<const core::FrameMatrix> joints(motion.joints.data(), 120, expected.cols());
  const Eigen::Map<const core::FrameMatrix> markers(motion.markers.data(), 120, 3 * names.size());
  core::FrameMatrix difference = joints - expected;
  const float floor_m = difference(0, 2);
  for (Eigen::Index z = 2; z < difference.cols(); z += 3) difference.col(z).array() -= floor_m;
  CHECK(difference.cwiseAbs().maxCoeff() < 1e-4F);
  for (int m = 0; m < names.size(); ++m) {
    const int joint = IndexOf(names[m], joint_names);
    REQUIRE(joint < joint_names.size());
    CHECK((markers.middleCols<3>(3 * m) - joints.middleCols<3>(3 * joint)).cwiseAbs().maxCoeff() <
          1e-4F);
  }
}

TEST_CASE("ReadClipMotion: parts of a clip", "[server][view]") {
  TestServer& server = TrainedServer();
  const Motion all = ReadMotion(server, MotionRequest(kWalk));
  REQUIRE(all.status.ok());
  CHECK(all.joints.empty());
  const std::size_t columns = all.markers.size() / 120;
  const auto check = [&](int first, int count, int stride, std::vector<int> frames) {
    INFO(first << ", " << count << ", " << stride);
    auto request = MotionRequest(kWalk);
    request.set_first_frame(first);
    request.set_frame_count(count);
    request.set_stride(stride);
    const Motion part = ReadMotion(server, request);
    REQUIRE(part.status.ok());
    CHECK(part.blocks[0].clip_frame_count() == 120);
    CHECK(part.blocks[0].first_frame() == first);
    CHECK(part.blocks[0].frame_count() == static_cast<int>(frames.size()));
    std::vector<float> expected;
    std::string contacts;
    for (const int frame : frames) {
      const auto begin = all.markers.begin() + static_cast<std::ptrdiff_t>(columns) * frame;
      expected.insert(expected.end(), begin, begin + static_cast<std::ptrdiff_t>(columns));
      contacts += all.contacts[static_cast<std::size_t>(frame)];
    }
    CHECK(part.markers == expected);
    CHECK(part.contacts == contacts);
  };
  check(10, 3, 0, {10, 11, 12});
  check(0, 4, 30, {0, 30, 60, 90});
  check(0, 100, 40, {0, 40, 80});
  check(119, 0, 1, {119});
  check(100, 0, 19, {100, 119});
  check(0, 2, 2'000'000'000, {0});
}

TEST_CASE("ReadClipMotion: long clips are sent in blocks", "[server][view]") {
  TestServer server;
  server.CreateDatabase("db");
  server.IngestFigure("db", "long", "walk", {.frame_count = 20000});
  auto request = MotionRequest("databases/db/clips/long");
  request.set_joints(true);
  const Motion motion = ReadMotion(server, request);
  INFO(motion.status.error_message());
  REQUIRE(motion.status.ok());
  CHECK(motion.blocks.size() > 2);
  int next = 0;
  for (const auto& block : motion.blocks) {
    CHECK(block.has_figure() == (next == 0));
    CHECK(block.first_frame() == next);
    next += block.frame_count();
  }
  CHECK(next == 20000);
  CHECK(motion.contacts.size() == 20000);
}

TEST_CASE("ReadClipMotion: ranges outside the clip name the field", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto violated = [&](int first, int count, int stride) {
    auto request = MotionRequest(kWalk);
    request.set_first_frame(first);
    request.set_frame_count(count);
    request.set_stride(stride);
    const Motion motion = ReadMotion(server, request);
    CHECK(motion.status.error_code() == StatusCode::INVALID_ARGUMENT);
    CHECK(motion.blocks.empty());
    return ViolatedFields(motion.status);
  };
  CHECK(violated(-1, 0, 0) == "first_frame");
  CHECK(violated(120, 0, 0) == "first_frame");
  CHECK(violated(0, -1, 0) == "frame_count");
  CHECK(violated(0, 0, -2) == "stride");
  CHECK(ReadMotion(server, MotionRequest("databases/db/clips/none")).status.error_code() ==
        StatusCode::NOT_FOUND);
  CHECK(ViolatedFields(ReadMotion(server, MotionRequest("walk")).status) == "name");
}

TEST_CASE("ReadClipMotion: before there is a model", "[server][view]") {
  server::ServerOptions options = With({});
  options.engine.rebuild_delay = options.engine.rebuild_delay_limit = std::chrono::hours(1);
  TestServer server(options);
  server.CreateDatabase("db");
  server.IngestFigure("db", "walk", "walk", {.frame_count = 120});
  const Motion motion = ReadMotion(server, MotionRequest(kWalk));
  INFO(motion.status.error_message());
  CHECK(motion.status.ok());
  CHECK(motion.blocks.at(0).figure().marker_bones_size() == 9);
  CHECK(motion.contacts.size() == 120);
}

TEST_CASE("GetNodePoses: the mean states of nodes", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto live = server.server().engine().FindDatabase("db");
  REQUIRE(live.ok());
  const auto snapshot = (*live)->lifecycle().snapshot();
  const core::Model& model = snapshot->model;
  const auto stub = server.NewStub<v1::ViewService>();
  for (int layer = 0; layer <= model.layer_count(); ++layer) {
    v1::GetNodePosesRequest request;
    request.set_parent(kCurrent);
    if (layer > 0) request.set_layer(layer);
    const int shown = layer > 0 ? layer : model.layer_count();
    for (int node = model.tree().node_count(shown) - 1; node >= 0; --node) {
      request.add_node_ids(node);
    }
    const auto answer = Ask(*stub, &Stub::GetNodePoses, request);
    INFO(answer.status.error_message());
    REQUIRE(answer.status.ok());
    CHECK(answer.response.layer() == shown);
    REQUIRE(answer.response.poses_size() == request.node_ids_size());
    for (int i = 0; i < request.node_ids_size(); ++i) {
      const v1::NodePose& pose = answer.response.poses(i);
      CHECK(pose.node_id() == request.node_ids(i));
      const core::MeanPose expected = core::MeanPoseOf(model, shown, pose.node_id());
      const auto same = [](const std::string& bytes, const Eigen::RowVectorXf& values) {
        return Unpack(bytes) == std::vector<float>(values.begin(), values.end());
      };
      CHECK(same(pose.marker_positions(), expected.positions_m));
      CHECK(same(pose.marker_velocities(), expected.velocities_m_s));
    }
  }
}

TEST_CASE("GetNodePoses: errors", "[server][view]") {
  TestServer& server = TrainedServer();
  const auto stub = server.NewStub<v1::ViewService>();
  const auto status = [&](const std::string& parent, int layer, const std::vector<int>& nodes) {
    v1::GetNodePosesRequest request;
    request.set_parent(parent);
    if (layer != 0) request.set_layer(layer);
    for (const int node : nodes) request.add_node_ids(node);
    return Ask(*stub, &Stub::GetNodePoses, request).status;
  };
  CHECK(status("databases/empty/models/current", 0, {0}).error_code() ==
        StatusCode::FAILED_PRECONDITION);
  CHECK(status("databases/none/models/current", 0, {0}).error_code() == StatusCode::NOT_FOUND);
  CHECK(ViolatedFields(status("databases/db", 0, {0})) == "parent");
  CHECK(ViolatedFields(status(kCurrent, 99, {0})) == "layer");
  CHECK(ViolatedFields(status(kCurrent, 1, {})) == "node_ids");
  CHECK(ViolatedFields(status(kCurrent, 1, {1})) == "node_ids");
  CHECK(ViolatedFields(status(kCurrent, 1, {0, -1})) == "node_ids");
  CHECK(ViolatedFields(status(kCurrent, 1, std::vector<int>(1001, 0))) == "node_ids");
  CHECK(status(kCurrent, 1, std::vector<int>(1000, 0)).ok());
}

TEST_CASE("ViewService: a token of another database is refused", "[server][view]") {
  TestServer server;
  server.CreateTrained("db");
  server.CreateDatabase("other");
  v1::CreateTokenRequest create;
  create.mutable_token()->set_role(v1::ROLE_READER);
  create.mutable_token()->set_database("databases/other");
  const auto made =
      Ask(*server.NewStub<v1::AccessService>(), &v1::AccessService::Stub::CreateToken, create);
  REQUIRE(made.status.ok());
  server.options().security.authentication = server::Authentication::kToken;
  server.Restart();
  const auto stub = server.NewStub<v1::ViewService>();
  v1::GetFigureRequest figure;
  figure.set_name("databases/db");
  CHECK(Ask(*stub, &Stub::GetFigure, figure, made.response.secret()).status.error_code() ==
        StatusCode::PERMISSION_DENIED);
  v1::GetNodePosesRequest poses;
  poses.set_parent(kCurrent);
  CHECK(Ask(*stub, &Stub::GetNodePoses, poses, made.response.secret()).status.error_code() ==
        StatusCode::PERMISSION_DENIED);
  CHECK(ReadMotion(server, MotionRequest(kWalk)).status.error_code() ==
        StatusCode::UNAUTHENTICATED);
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer " + made.response.secret());
  v1::ReadStateMapRequest map;
  map.set_parent(kCurrent);
  v1::ReadStateMapResponse part;
  const auto reader = stub->ReadStateMap(&context, map);
  CHECK_FALSE(reader->Read(&part));
  CHECK(reader->Finish().error_code() == StatusCode::PERMISSION_DENIED);
}

}  // namespace
}  // namespace motiondb::tests::view_service_test
