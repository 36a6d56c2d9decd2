// Impossible motion: extreme marker positions and very large marker sets.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::tests::state_limits_test {
namespace {

using Catch::Contains;

core::MarkerMotion Hips(float height_m, int frames = 4) {
  core::MarkerMotion motion{{"lhip", "rhip", "head", "sole"}, 60, core::FrameMatrix(frames, 12)};
  for (int t = 0; t < frames; ++t) {
    const auto time = static_cast<float>(t);
    motion.positions_m.row(t) << 0, 0.1F, height_m, 0, -0.1F, height_m,  //
        0.01F * time, 0, 2 * height_m, 0, 0, 0;
  }
  return motion;
}

absl::StatusOr<core::StateSequence> Represented(const core::MarkerMotion& motion,
                                                core::Cleaning cleaning) {
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  return core::Represent(*scheme, motion, 30, cleaning);
}

TEST_CASE("Represent: a marker too far away is refused with frame and name",
          "[core][motion][hostile]") {
  for (const float far : {2e5F, 3e38F, -INFINITY}) {
    core::MarkerMotion motion = Hips(0.9F);
    motion.positions_m(2, 7) = far;
    for (const auto& cleaning : {core::Cleaning(core::GlitchPolicy::kKeep), core::kObservation}) {
      const auto states = Represented(motion, cleaning);
      REQUIRE(states.status().code() == absl::StatusCode::kInvalidArgument);
      CHECK_THAT(std::string(states.status().message()), Contains("frame 3, marker 'head'"));
    }
  }
  REQUIRE(Represented(Hips(0.9F), core::GlitchPolicy::kRepair).ok());
}

// Hips at this height in every frame.
core::JointMotion HipsAtHeight(int frame_count, double height_m) {
  core::Joint root{.name = "hips"};
  root.dofs = {{.kind = core::Dof::Kind::kTranslation, .axis = Eigen::Vector3d::UnitZ()}};
  const core::Joint left{.name = "lhip", .parent = 0, .offset_m = {0, 0.1, 0}};
  const core::Joint right{.name = "rhip", .parent = 0, .offset_m = {0, -0.1, 0}};
  const auto skeleton = core::Skeleton::Create("lift", {root, left, right});
  REQUIRE(skeleton.ok());
  return {std::make_shared<const core::Skeleton>(*skeleton), 60,
          core::JointMatrix::Constant(frame_count, 1, height_m)};
}

TEST_CASE("Represent: joints that slide too far are refused", "[core][motion][hostile]") {
  core::JointMotion motion = HipsAtHeight(3, 1e300);
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  const auto states = core::Represent(*scheme, motion, 60, core::GlitchPolicy::kRepair, 0.9);
  CHECK(states.status().code() == absl::StatusCode::kInvalidArgument);
}

TEST_CASE("Represent: a leg length that makes floats overflow is refused",
          "[core][motion][hostile]") {
  const core::MarkerMotion motion = Hips(0.9F);
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  for (const double leg : {1e-30, 1e30}) {
    const auto states = core::Represent(*scheme, motion, 60, core::kObservation, leg);
    REQUIRE(states.status().code() == absl::StatusCode::kInvalidArgument);
    CHECK_THAT(std::string(states.status().message()), Contains("leg_length_m: "));
  }
  // The same size, measured from the markers.
  CHECK(Represented(Hips(1e-9F), core::kObservation).status().code() ==
        absl::StatusCode::kInvalidArgument);
}

TEST_CASE("Represent: stops soon after cancellation, at any point", "[core][motion]") {
  const core::JointMotion motion = HipsAtHeight(1000, 1);
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.ok());
  int checks = 0;
  int allowed_checks = 1000;
  const auto represent = [&] {
    checks = 0;
    return core::Represent(*scheme, motion, 60, core::kObservation, 0.9, nullptr,
                           [&] { return ++checks > allowed_checks; });
  };
  REQUIRE(represent().ok());
  // In the mapping and between the later steps.
  const int total_checks = checks;
  CHECK(total_checks >= 4);
  for (allowed_checks = 0; allowed_checks < total_checks; ++allowed_checks) {
    CHECK(represent().status().code() == absl::StatusCode::kCancelled);
    CHECK(checks == allowed_checks + 1);
  }
}

TEST_CASE("SourceScheme: too many markers are refused", "[core][motion][hostile]") {
  core::MarkerMotion motion = Hips(0.9F);
  while (motion.names.size() <= core::kMaxMarkers) {
    motion.names.push_back("m" + std::to_string(motion.names.size()));
  }
  motion.positions_m.setZero(4, 3 * std::ssize(motion.names));
  const auto scheme = core::SourceScheme(motion);
  REQUIRE(scheme.status().code() == absl::StatusCode::kInvalidArgument);
  CHECK_THAT(std::string(scheme.status().message()), Contains("at most 256"));
  motion.names.pop_back();
  CHECK(core::SourceScheme(motion).ok());
}

}  // namespace
}  // namespace motiondb::tests::state_limits_test
