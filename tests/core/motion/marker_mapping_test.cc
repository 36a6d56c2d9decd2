#include <catch2/catch.hpp>
#include <memory>

#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::tests::marker_mapping_test {
namespace {

core::MarkerMotion Markers(std::vector<std::string> names) {
  core::MarkerMotion motion{std::move(names), 60, {}};
  motion.positions_m.resize(2, static_cast<Eigen::Index>(3 * motion.names.size()));
  for (Eigen::Index i = 0; i < motion.positions_m.size(); ++i) {
    motion.positions_m.data()[i] = static_cast<float>(i);
  }
  return motion;
}

core::MarkerScheme Scheme() {
  core::MarkerScheme scheme;
  scheme.set.name = "two";
  scheme.set.markers = {"A", "B"};
  scheme.set.landmarks.left_hip = 0;
  scheme.set.landmarks.right_hip = 1;
  scheme.mappings.push_back(
      {"plain", {"p", "q"}, {{{{"p", 1}}, "", {}}, {{{"p", 0.25}, {"q", 0.75}}, "", {}}}});
  return scheme;
}

}  // namespace

TEST_CASE("RecognizeLandmarks: knows the names used in common files", "[core][motion]") {
  const std::vector<std::vector<std::string>> customs = {
      {"Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot"},
      {"root", "lfemur", "ltibia", "lfoot", "rfemur", "rtibia", "rfoot"},
      {"hip", "lThigh", "lShin", "lFoot", "rThigh", "rShin", "rFoot"},
      {"Hips", "LeftHip", "LeftKnee", "LeftAnkle", "RightHip", "RightKnee", "RightAnkle"},
      {"x", "Sub:LASI", "Sub:LKNE", "Sub:LANK", "Sub:RASI", "Sub:RKNE", "Sub:RANK"},
      {"pelvis", "thigh_l", "calf_l", "foot_l", "thigh_r", "calf_r", "foot_r"},
      {"x", "CC_Base_L_Thigh", "CC_Base_L_Calf", "CC_Base_L_Foot", "CC_Base_R_Thigh",
       "CC_Base_R_Calf", "CC_Base_R_Foot"},
  };
  for (const auto& names : customs) {
    CAPTURE(names);
    const core::Landmarks landmarks = core::RecognizeLandmarks(names);
    CHECK(landmarks.left_hip == 1);
    CHECK(landmarks.right_hip == 4);
    REQUIRE(landmarks.legs.size() == 2);
    CHECK(landmarks.legs[0] == std::array<int, 3>{1, 2, 3});
    CHECK(landmarks.legs[1] == std::array<int, 3>{4, 5, 6});
  }
  CHECK(core::RecognizeLandmarks({"a", "b"}).left_hip == -1);
}

TEST_CASE("ApplyScheme: weighted sums of named points", "[core][motion]") {
  const core::MarkerMotion motion = Markers({"other", "q", "p"});
  const auto mapped = core::ApplyScheme(Scheme(), motion);
  REQUIRE(mapped.ok());
  CHECK(mapped->names == std::vector<std::string>{"A", "B"});
  CHECK(mapped->positions_m.leftCols<3>() == motion.positions_m.middleCols<3>(6));
  CHECK(mapped->positions_m.rightCols<3>().isApprox(0.25f * motion.positions_m.middleCols<3>(6) +
                                                    0.75f * motion.positions_m.middleCols<3>(3)));
}

TEST_CASE("ApplyScheme: the set's own names need no mapping; the largest signature wins",
          "[core][motion]") {
  const core::MarkerMotion own = Markers({"B", "A"});
  const auto mapped = core::ApplyScheme(Scheme(), own);
  REQUIRE(mapped.ok());
  CHECK(mapped->positions_m.leftCols<3>() == own.positions_m.rightCols<3>());

  core::MarkerScheme scheme = Scheme();
  scheme.mappings.push_back(
      {"fuller", {"p", "q", "r"}, {{{{"r", 1}}, "", {}}, {{{"q", 1}}, "", {}}}});
  const core::MarkerMotion three = Markers({"p", "q", "r"});
  const auto fuller = core::ApplyScheme(scheme, three);
  REQUIRE(fuller.ok());
  CHECK(fuller->positions_m.leftCols<3>() == three.positions_m.rightCols<3>());
}

TEST_CASE("ApplyScheme: offsets rotate with their link and scale with the leg", "[core][motion]") {
  core::Joint root{.name = "p"};
  root.dofs = {{core::Dof::Kind::kRotation, Eigen::Vector3d::UnitZ()}};
  core::Joint child{.name = "q", .parent = 0, .offset_m = {1, 0, 0}};
  auto skeleton = core::Skeleton::Create("s", {root, child});
  REQUIRE(skeleton.ok());
  core::JointMotion motion{std::make_shared<core::Skeleton>(*skeleton), 60,
                           core::JointMatrix(2, 1)};
  motion.angles << 0, M_PI / 2;
  core::MarkerScheme scheme = Scheme();
  scheme.mappings[0].rules[1] = {{{"q", 1}}, "q", {0.5, 0, 0}};
  const auto mapped = core::ApplyScheme(scheme, motion, 2.0);
  REQUIRE(mapped.ok());
  const Eigen::RowVectorXf along_x = mapped->positions_m.row(0).tail<3>();
  const Eigen::RowVectorXf along_y = mapped->positions_m.row(1).tail<3>();
  CHECK(along_x.isApprox(Eigen::RowVector3f(2, 0, 0), 1e-5f));
  CHECK((along_y - Eigen::RowVector3f(0, 2, 0)).norm() < 1e-5f);
}

TEST_CASE("ApplyScheme: reports the missing names of the closest mapping", "[core][motion]") {
  const auto mapped = core::ApplyScheme(Scheme(), Markers({"p", "z"}));
  REQUIRE_FALSE(mapped.ok());
  CHECK(mapped.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(mapped.status().message()),
             Catch::Matchers::Contains("'plain'") && Catch::Matchers::Contains("'q'"));
}

TEST_CASE("SourceScheme: the motion's own names, without end sites", "[core][motion]") {
  const auto scheme = core::SourceScheme(Markers({"LHip", "RHip", "Nose_end"}));
  REQUIRE(scheme.ok());
  CHECK(scheme->set.markers.size() == 3);  // a marker may have any name
  core::Joint hips{.name = "Hips"};
  core::Joint left{.name = "LeftUpLeg", .parent = 0};
  core::Joint right{.name = "RightUpLeg", .parent = 0};
  core::Joint end{.name = "LeftUpLeg_end", .parent = 1};
  auto skeleton = core::Skeleton::Create("s", {hips, left, right, end});
  REQUIRE(skeleton.ok());
  const auto joints = core::SourceScheme(
      core::JointMotion{std::make_shared<core::Skeleton>(*skeleton), 60, core::JointMatrix(2, 0)});
  REQUIRE(joints.ok());
  CHECK(joints->set.markers == std::vector<std::string>{"Hips", "LeftUpLeg", "RightUpLeg"});
  CHECK(joints->set.landmarks.left_hip == 1);

  const auto refused = core::SourceScheme(Markers({"a", "b"}));
  REQUIRE_FALSE(refused.ok());
  CHECK_THAT(std::string(refused.status().message()), Catch::Matchers::Contains("marker-set file"));
}

}  // namespace motiondb::tests::marker_mapping_test
