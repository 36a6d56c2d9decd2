#include "core/motion/corrections.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "core/format/marker_set_file.h"
#include "core/motion/states.h"

namespace motiondb::tests::corrections_test {
namespace {

constexpr double kLeg_m = 0.85;
constexpr double kRate_hz = 60;

const core::MarkerSet& Set() { return core::StandardScheme().set; }

Eigen::Index Marker(const std::string& name) {
  return std::ranges::find(Set().markers, name) - Set().markers.begin();
}

// A person who looks along x. Both arms are `elevation_rad` from the trunk, in front of the body by
// `front_rad`; the left thigh is lifted by `swing_rad`.
Eigen::RowVectorXf Pose(double elevation_rad, double front_rad = 0, double swing_rad = 0) {
  Eigen::RowVectorXf row = Eigen::RowVectorXf::Constant(
      3 * static_cast<Eigen::Index>(Set().markers.size()), std::nanf(""));
  const auto put = [&](const std::string& name, const Eigen::Vector3d& at) {
    row.segment<3>(3 * Marker(name)) = at.cast<float>();
  };
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? "L" : "R";
    const double lift = side > 0 ? swing_rad : 0;
    const Eigen::Vector3d thigh(0.42 * std::sin(lift), 0, -0.42 * std::cos(lift));
    const Eigen::Vector3d hip(0, 0.09 * side, 0.93);
    put(s + "Hip", hip);
    put(s + "Knee", hip + thigh);
    put(s + "Ankle", hip + thigh + Eigen::Vector3d(0, 0, -0.43));
    const double out = std::sin(elevation_rad);
    const Eigen::Vector3d arm(out * std::sin(front_rad), side * out * std::cos(front_rad),
                              -std::cos(elevation_rad));
    const Eigen::Vector3d shoulder(0, 0.19 * side, 1.43);
    put(s + "Shoulder", shoulder);
    put(s + "Elbow", shoulder + 0.3 * arm);
    put(s + "Wrist", shoulder + 0.56 * arm);
  }
  put("Neck", {0, 0, 1.42});
  return row;
}

constexpr double kDegree = std::numbers::pi / 180;

// `held` frames of a pose, then steps with lowered arms.
core::MarkerMotion Held(const Eigen::RowVectorXf& pose, int held) {
  constexpr int kSteps = 120;
  core::MarkerMotion motion{Set().markers, kRate_hz, core::FrameMatrix(held + kSteps, pose.cols())};
  for (int t = 0; t < held + kSteps; ++t) {
    motion.positions_m.row(t) =
        t < held ? pose : Pose(12 * kDegree, 0, 0.5 * std::sin(0.1 * (t - held)));
  }
  return motion;
}

core::PoseAtStart Find(const core::MarkerMotion& motion) {
  return core::FindPoseAtStart(Set(), motion, kLeg_m);
}

TEST_CASE("FindPoseAtStart: a T-pose or A-pose of one frame or several", "[core][motion]") {
  for (const int held : {1, 2, 90}) {
    CAPTURE(held);
    const core::PoseAtStart level = Find(Held(Pose(90 * kDegree), held));
    CHECK(level.pose == core::ReferencePose::kT);
    CHECK(level.frame_count == held);
    const core::PoseAtStart lowered = Find(Held(Pose(45 * kDegree), held));
    CHECK(lowered.pose == core::ReferencePose::kA);
    CHECK(lowered.frame_count == held);
  }
}

TEST_CASE("ReplacePoseAtStart: by the first frame after it; other frames stay", "[core][motion]") {
  const core::MarkerMotion posed = Held(Pose(90 * kDegree), 3);
  core::MarkerMotion motion = posed;
  core::ReplacePoseAtStart(Set(), kLeg_m, motion);
  const auto equal = [](const Eigen::RowVectorXf& a, const Eigen::RowVectorXf& b) {
    return ((a - b).array() == 0 || (a.array().isNaN() && b.array().isNaN())).all();
  };
  REQUIRE(motion.positions_m.rows() == posed.positions_m.rows());
  for (Eigen::Index t = 0; t < posed.positions_m.rows(); ++t) {
    CHECK(equal(motion.positions_m.row(t), posed.positions_m.row(std::max<Eigen::Index>(3, t))));
  }
}

TEST_CASE("FindPoseAtStart: frames that a filter made of the jump", "[core][motion]") {
  core::MarkerMotion motion = Held(Pose(90 * kDegree), 8);
  const double elevations[] = {70, 45, 25, 16, 12.5};  // after frame 2
  for (int i = 0; i < 5; ++i) motion.positions_m.row(3 + i) = Pose(elevations[i] * kDegree);
  CHECK(Find(motion).frame_count == 7);
}

TEST_CASE("FindPoseAtStart: other poses, and motion through the pose, stay", "[core][motion]") {
  CHECK(Find(Held(Pose(12 * kDegree), 90)).frame_count == 0);                // standing
  CHECK(Find(Held(Pose(90 * kDegree, 90 * kDegree), 90)).frame_count == 0);  // arms to the front
  CHECK(Find(Held(Pose(170 * kDegree), 90)).frame_count == 0);               // arms above the head
  CHECK(Find(Held(Pose(90 * kDegree, 0, 60 * kDegree), 90)).frame_count == 0);  // on one leg
  core::MarkerMotion lowering = Held(Pose(90 * kDegree), 1);
  for (int t = 0; t < 60; ++t) lowering.positions_m.row(t) = Pose((90 - t) * kDegree);
  CHECK(Find(lowering).frame_count == 0);
  core::MarkerMotion whole = Held(Pose(90 * kDegree), 90);
  whole.positions_m.conservativeResize(90, whole.positions_m.cols());
  CHECK(Find(whole).frame_count == 0);
  core::MarkerMotion without_arms = Held(Pose(90 * kDegree), 10);
  without_arms.positions_m.middleCols<3>(3 * Marker("LElbow")).setConstant(std::nanf(""));
  CHECK(Find(without_arms).frame_count == 0);
  CHECK(core::FindPoseAtStart({}, lowering, kLeg_m).frame_count == 0);
}

TEST_CASE("AddDerivedMarkers: feet point to the front, the head is above the neck",
          "[core][motion]") {
  core::MarkerMotion motion = Held(Pose(12 * kDegree), 3);
  // Turned by 90 degrees: the front is y.
  for (Eigen::Index m = 0; m < std::ssize(Set().markers); ++m) {
    const Eigen::VectorXf x = motion.positions_m.col(3 * m);
    motion.positions_m.col(3 * m) = -motion.positions_m.col(3 * m + 1);
    motion.positions_m.col(3 * m + 1) = x;
  }
  std::vector<std::string> notes;
  REQUIRE(core::AddDerivedMarkers(Set(), kLeg_m, motion, notes).ok());
  REQUIRE(notes.size() == 1);
  CHECK(notes[0] ==
        "derived from the proportions of a person: LToe, RToe, LHeel, RHeel, Head, HeadTop");
  const auto offset = [&](const char* marker, const char* from) -> Eigen::Vector3d {
    return (motion.positions_m.row(1).segment<3>(3 * Marker(marker)) -
            motion.positions_m.row(1).segment<3>(3 * Marker(from)))
        .transpose()
        .cast<double>();
  };
  CHECK(offset("LToe", "LAnkle").isApprox(kLeg_m * Eigen::Vector3d(0, 0.14, -0.07), 1e-4));
  CHECK(offset("HeadTop", "Neck").isApprox(kLeg_m * Eigen::Vector3d(0, 0.03, 0.33), 1e-4));
  // Nothing is left to derive, and other markers are not derived.
  notes.clear();
  REQUIRE(core::AddDerivedMarkers(Set(), kLeg_m, motion, notes).ok());
  CHECK(notes.empty());
  CHECK(motion.positions_m.middleCols<3>(3 * Marker("LHand")).array().isNaN().all());
}

}  // namespace

}  // namespace motiondb::tests::corrections_test
