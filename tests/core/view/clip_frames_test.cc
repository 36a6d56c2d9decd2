// What a picture shows of the frames of a clip: joints and standing feet.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/format/motion_file.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/states.h"
#include "core/view/clip_picture.h"
#include "tests/core/planning/walking_figure.h"
#include "tests/support/stick_figure.h"

namespace motiondb::tests::clip_frames_test {
namespace {

core::JointMotion ReadFigure(const StickFigure& figure) {
  const std::string bytes = WriteBvh(figure);
  auto file = core::ReadMotionFile(core::FileFormat::kBvh, {"figure.bvh", bytes});
  INFO(file.status());
  REQUIRE(file.ok());
  return std::get<core::JointMotion>(file->motion);
}

// Markers of a `source` set are joints, so their stored positions are an oracle.
TEST_CASE("RecordedJoints: joints are where the stored markers of these joints are",
          "[core][view]") {
  for (const double rate_hz : {60.0, 30.0, 47.5, 120.0}) {
    for (const Act act : {Act::kWalk, Act::kSquat, Act::kWave}) {
      const core::JointMotion motion =
          ReadFigure({.act = act, .frame_count = 90, .frame_rate_hz = 60});
      const auto scheme = core::SourceScheme(motion);
      REQUIRE(scheme.ok());
      core::SourcePart part;
      const auto states = core::Represent(*scheme, motion, rate_hz, core::GlitchPolicy::kRepair,
                                          std::nullopt, nullptr, {}, &part);
      REQUIRE(states.ok());
      CHECK(part.first_frame == 0);
      CHECK(part.frame_count == 90);
      const auto joints = core::RecordedJoints(motion, part, rate_hz);
      REQUIRE(joints.ok());
      REQUIRE(joints->rows() == states->frame_count());
      const core::FrameMatrix markers = core::WorldPositions(*states);
      for (std::size_t m = 0; m < scheme->set.markers.size(); ++m) {
        const int joint = motion.skeleton->FindJoint(scheme->set.markers[m]);
        REQUIRE(joint >= 0);
        const auto column = static_cast<Eigen::Index>(3 * m);
        CHECK((joints->middleCols<3>(3 * joint) - markers.middleCols<3>(column))
                  .cwiseAbs()
                  .maxCoeff() < 1e-4F);
      }
    }
  }
}

TEST_CASE("RecordedJoints: a part of the frames, on the floor", "[core][view]") {
  const core::JointMotion motion = ReadFigure({.frame_count = 80});
  const core::FrameMatrix all = core::JointPositions(motion);
  const auto part = core::RecordedJoints(motion, {20, 40, 0.25}, motion.frame_rate_hz);
  REQUIRE(part.ok());
  core::FrameMatrix expected = all.middleRows(20, 40);
  for (Eigen::Index column = 2; column < expected.cols(); column += 3) {
    expected.col(column).array() -= 0.25F;
  }
  CHECK((*part - expected).cwiseAbs().maxCoeff() < 1e-6F);
  CHECK(absl::IsInvalidArgument(core::RecordedJoints(motion, {0, 1, 0}, 60).status()));
}

TEST_CASE("RecordedRotations: rotations go with the positions of joints", "[core][view]") {
  const core::JointMotion motion = ReadFigure({.act = Act::kWave, .frame_count = 90});
  const core::Skeleton& skeleton = *motion.skeleton;
  for (const double rate_hz : {60.0, 30.0, 47.5, 120.0}) {
    const core::SourcePart part{10, 70, 0.25};
    const auto joints = core::RecordedJoints(motion, part, rate_hz);
    const auto rotations = core::RecordedRotations(motion, part, rate_hz);
    REQUIRE(joints.ok());
    REQUIRE(rotations.ok());
    REQUIRE(rotations->rows() == joints->rows());
    REQUIRE(rotations->cols() == 4 * skeleton.joint_count());
    for (Eigen::Index frame = 0; frame < joints->rows(); ++frame) {
      for (int j = 1; j < skeleton.joint_count(); ++j) {
        const core::Joint& joint = skeleton.joints()[j];
        const Eigen::Vector4f numbers = rotations->block<1, 4>(frame, 4 * joint.parent).transpose();
        CHECK(numbers.norm() == Approx(1).margin(1e-5));
        const Eigen::Vector3f along =
            Eigen::Quaternionf(numbers) * joint.offset_m.cast<float>().eval();
        const Eigen::Vector3f link =
            (joints->block<1, 3>(frame, 3 * j) - joints->block<1, 3>(frame, 3 * joint.parent))
                .transpose();
        CHECK((along - link).norm() < 1e-3F);
      }
    }
  }
  CHECK(absl::IsInvalidArgument(core::RecordedRotations(motion, {0, 1, 0}, 60).status()));
}

TEST_CASE("Represent: names the part of the source", "[core][view]") {
  // One marker jumps far for a moment; the longer rest is stored.
  core::MarkerMotion motion = WalkingFigure{.seconds = 3}.Motion();
  motion.positions_m.block(60, 3 * WalkerIndex(0, kKnee), 1, 3).array() += 3;
  core::SourcePart part;
  const auto states = core::Represent({WalkerSet(), {}}, motion, 60, core::GlitchPolicy::kDrop,
                                      std::nullopt, nullptr, {}, &part);
  INFO(states.status());
  REQUIRE(states.ok());
  CHECK(part.first_frame > 60);
  CHECK(part.first_frame < 70);
  CHECK(part.first_frame + part.frame_count == motion.positions_m.rows());
  CHECK(part.frame_count == states->frame_count());
}

TEST_CASE("StandingFeet: the known contacts of a walker", "[core][view]") {
  const WalkingFigure walker;
  const core::FrameMatrix positions_m = walker.Motion().positions_m;
  auto states = core::ComputeStates(WalkerSet(), walker.Motion());
  REQUIRE(states.ok());
  const core::Feet of_model = core::FindFeet(walker.Model());
  for (const core::Feet& feet : {of_model, core::FindFeet(WalkerSet(), states->states)}) {
    const auto standing =
        core::StandingFeet(WalkerSet(), feet, positions_m, walker.rate_hz, WalkingFigure::kLeg_m);
    REQUIRE(static_cast<Eigen::Index>(standing.size()) == positions_m.rows());
    int wrong = 0;
    for (std::size_t f = 0; f < standing.size(); ++f) {
      const double t = static_cast<double>(f) / walker.rate_hz;
      for (const int side : {0, 1}) {
        const bool stands = walker.Stands(side, kHeel, t) || walker.Stands(side, kToe, t);
        const auto bit = side == 0 ? core::kLeftFoot : core::kRightFoot;
        wrong += ((standing[f] & bit) != 0) == stands ? 0 : 1;
      }
    }
    CHECK(wrong < 0.1 * 2 * static_cast<double>(standing.size()));
  }
  core::MarkerSet legless = WalkerSet();
  legless.landmarks.legs.clear();
  CHECK(core::FindFeet(legless, states->states).empty());
  CHECK(core::StandingFeet(legless, {}, positions_m, 60, 0.9).empty());
}

}  // namespace
}  // namespace motiondb::tests::clip_frames_test
