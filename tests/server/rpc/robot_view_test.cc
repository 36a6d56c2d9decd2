// The motion of a robot: joints, visual shapes of its links, and rotations.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "motiondb/v1/clip.grpc.pb.h"
#include "motiondb/v1/view.grpc.pb.h"
#include "tests/core/format/biped_table.h"
#include "tests/support/packed_floats.h"
#include "tests/support/test_server.h"

namespace motiondb::tests::robot_view_test {
namespace {

constexpr double kTurn_rad_s = 0.8;

// A biped that turns to the left and swings its legs, two seconds at 50 Hz.
std::string Table() {
  std::string text =
      "time_s,root_x_m,root_y_m,root_z_m,root_qx,root_qy,root_qz,root_qw,"
      "l_hip,l_knee,r_hip,r_knee\n";
  for (int frame = 0; frame <= 100; ++frame) {
    const double t = 0.02 * frame;
    const double swing = 0.4 * std::sin(3 * t);
    text +=
        fmt::format("{:.2f},{:.6f},0,0.8,0,0,{:.9f},{:.9f},{:.6f},0.3,{:.6f},0.3\n", t, 0.5 * t,
                    std::sin(kTurn_rad_s * t / 2), std::cos(kTurn_rad_s * t / 2), swing, -swing);
  }
  return text;
}

// kBiped with shapes in its pelvis and its left shin, or with a mesh there.
std::string Biped(const std::string& shin) {
  const std::string pelvis =
      "<link name=\"pelvis\"><visual><origin xyz=\"0 0 0.1\" rpy=\"1.5707963267948966 0 0\"/>"
      "<geometry><box size=\"0.2 0.3 0.4\"/></geometry></visual></link>";
  const std::string text = Replaced(std::string(kBiped), "<link name=\"pelvis\"/>", pelvis);
  return Replaced(text, "<link name=\"l_shin\"/>",
                  fmt::format("<link name=\"l_shin\"><visual><geometry>{}</geometry></visual>"
                              "</link>",
                              shin));
}

void IngestRobot(TestServer& server, const std::string& clip, const std::string& urdf) {
  grpc::ClientContext context;
  v1::IngestClipResponse response;
  const auto stub = server.NewStub<v1::ClipService>();
  const auto writer = stub->IngestClip(&context, &response);
  v1::IngestClipRequest message;
  v1::IngestClipHeader& header = *message.mutable_header();
  header.set_parent("databases/robots");
  header.set_file_name(clip + ".csv");
  header.set_skeleton_file_name("biped.urdf");
  header.set_replace(true);
  header.set_clip_id(clip);
  writer->Write(message);
  message.set_skeleton_block(urdf);
  writer->Write(message);
  message.set_file_block(Table());
  writer->Write(message);
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  INFO(status.error_message());
  REQUIRE(status.ok());
}

// All frames of a clip, which fit into one message.
v1::ReadClipMotionResponse ReadFrames(TestServer& server, const std::string& clip, bool joints,
                                      int first_frame = 0) {
  v1::ReadClipMotionRequest request;
  request.set_name("databases/robots/clips/" + clip);
  request.set_joints(joints);
  request.set_first_frame(first_frame);
  grpc::ClientContext context;
  const auto stub = server.NewStub<v1::ViewService>();
  const auto reader = stub->ReadClipMotion(&context, request);
  v1::ReadClipMotionResponse response;
  REQUIRE(reader->Read(&response));
  v1::ReadClipMotionResponse more;
  CHECK_FALSE(reader->Read(&more));
  const grpc::Status status = reader->Finish();
  INFO(status.error_message());
  REQUIRE(status.ok());
  return response;
}

std::vector<float> Floats(const google::protobuf::RepeatedField<float>& values) {
  return {values.begin(), values.end()};
}

TEST_CASE("ReadClipMotion: the shapes of a robot and the rotations of its joints",
          "[server][view]") {
  TestServer server;
  server.CreateDatabase("robots");
  IngestRobot(server, "turn", Biped("<cylinder radius=\"0.05\" length=\"0.4\"/>"));
  const v1::ReadClipMotionResponse motion = ReadFrames(server, "turn", true);
  const v1::Figure& figure = motion.figure();
  REQUIRE(figure.joint_visuals_size() == 2);
  const v1::LinkVisual& box = figure.joint_visuals(0);
  CHECK(figure.joint_names(box.joint()) == "pelvis");
  CHECK(box.geometry() == v1::VISUAL_GEOMETRY_BOX);
  CHECK(Floats(box.size_m()) == std::vector<float>{0.2F, 0.3F, 0.4F});
  CHECK(Floats(box.position_m()) == std::vector<float>{0, 0, 0.1F});
  REQUIRE(box.rotation_size() == 4);
  CHECK(box.rotation(0) == Approx(std::sqrt(0.5)));
  CHECK(box.rotation(3) == Approx(std::sqrt(0.5)));
  const v1::LinkVisual& cylinder = figure.joint_visuals(1);
  // The knee moves the shin.
  CHECK(figure.joint_names(cylinder.joint()) == "l_knee");
  CHECK(cylinder.geometry() == v1::VISUAL_GEOMETRY_CYLINDER);
  CHECK(Floats(cylinder.size_m()) == std::vector<float>{0.1F, 0.1F, 0.4F});

  // 60 Hz: most frames are between those of the file.
  const int joints = figure.joint_names_size();
  REQUIRE(joints == 7);
  REQUIRE(motion.frame_count() == 121);
  const std::vector<float> positions = Unpack(motion.joint_positions());
  const std::vector<float> rotations = Unpack(motion.joint_rotations());
  REQUIRE(static_cast<int>(positions.size()) == 121 * joints * 3);
  REQUIRE(static_cast<int>(rotations.size()) == 121 * joints * 4);
  const auto position = [&](int frame, int joint) {
    return Eigen::Vector3f(positions.data() + 3 * (frame * joints + joint));
  };
  const auto rotation = [&](int frame, int joint) {
    const float* q = rotations.data() + 4 * (frame * joints + joint);
    return Eigen::Quaternionf(q[3], q[0], q[1], q[2]);
  };
  constexpr int kHip = 1;  // depth first: pelvis, l_hip, l_knee, l_ankle, ...
  for (int frame = 0; frame < 121; ++frame) {
    const double half = kTurn_rad_s * frame / 60 / 2;
    const Eigen::Quaternionf turned(static_cast<float>(std::cos(half)), 0, 0,
                                    static_cast<float>(std::sin(half)));
    CHECK(rotation(frame, 0).angularDistance(turned) < 2e-3F);
    CHECK(rotation(frame, kHip).norm() == Approx(1).margin(1e-5));
    // A thigh is 0.4 m long, a shin too, along -z of their frames.
    for (const int joint : {kHip, kHip + 1}) {
      const Eigen::Vector3f end =
          position(frame, joint) + rotation(frame, joint) * Eigen::Vector3f(0, 0, -0.4F);
      CHECK((end - position(frame, joint + 1)).norm() < 2e-3F);
    }
  }
  const v1::ReadClipMotionResponse part = ReadFrames(server, "turn", true, 100);
  CHECK(part.joint_rotations() == motion.joint_rotations().substr(100UL * joints * 16));
  // Without joints, nothing of them is sent.
  const v1::ReadClipMotionResponse markers = ReadFrames(server, "turn", false);
  CHECK(markers.figure().joint_visuals().empty());
  CHECK(markers.joint_rotations().empty());
}

TEST_CASE("ReadClipMotion: without shapes there are no rotations", "[server][view]") {
  TestServer server;
  server.CreateDatabase("robots");
  IngestRobot(server, "bare", std::string(kBiped));
  const v1::ReadClipMotionResponse bare = ReadFrames(server, "bare", true);
  CHECK(bare.joint_positions().size() == 121 * 7 * 12);
  CHECK(bare.figure().joint_visuals().empty());
  CHECK(bare.joint_rotations().empty());
  // An invalid shape and a mesh leave their links without shapes; the motion is stored.
  for (const char* shin : {"<sphere radius=\"nan\"/>", "<mesh filename=\"shin.dae\"/>"}) {
    CAPTURE(shin);
    IngestRobot(server, "bare", Biped(shin));
    const v1::ReadClipMotionResponse motion = ReadFrames(server, "bare", true);
    REQUIRE(motion.figure().joint_visuals_size() == 1);
    CHECK(motion.figure().joint_visuals(0).geometry() == v1::VISUAL_GEOMETRY_BOX);
  }
}

}  // namespace
}  // namespace motiondb::tests::robot_view_test
