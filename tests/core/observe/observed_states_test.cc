#include "core/observe/observed_states.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/motion/states.h"
#include "tests/core/observe/point_motion.h"

namespace motiondb::tests::observed_states_test {
namespace {

constexpr int kCapacity = 20;

core::ObservedStates Empty() {
  core::ObservedStates states(PointScheme().set, 60, kCapacity);
  states.set_leg_length_m(kLegLength_m);
  return states;
}

void CheckSame(const core::StateSequence& a, const core::StateSequence& b) {
  REQUIRE(a.states.rows() == b.states.rows());
  for (Eigen::Index i = 0; i < a.states.size(); ++i) {
    REQUIRE(std::isnan(a.states.data()[i]) == std::isnan(b.states.data()[i]));
    if (std::isnan(a.states.data()[i])) continue;
    REQUIRE(a.states.data()[i] == Approx(b.states.data()[i]).margin(1e-5));
  }
  CHECK((a.root_path - b.root_path).cwiseAbs().maxCoeff() < 1e-9);
}

}  // namespace

TEST_CASE("ObservedStates: after each frame they equal the states of the past", "[core][observe]") {
  core::MarkerMotion motion = PointMotion(400, 2, 1);  // makes more than one full turn
  Hide(motion, 3, 40, 41);
  Hide(motion, 4, 60, 90);
  Hide(motion, 5, 0, 3);
  const core::StateSequence whole = PointStates(motion);
  core::ObservedStates states = Empty();
  for (int t = 0; t < 400; ++t) {
    REQUIRE(states.Push(motion.positions_m.row(t)));
    CHECK(states.next() == t + 1);
    CHECK(states.kept() == std::min(t + 1, kCapacity));
    core::MarkerMotion prefix = motion;
    prefix.positions_m.conservativeResize(t + 1, Eigen::NoChange);
    CAPTURE(t);
    const core::StateSequence known = PointStates(prefix);
    CheckSame(states.Last(states.kept()), core::PastAt(known, t, kCapacity));
    if (t % 40 == 20) CheckSame(states.Last(states.kept()), core::PastAt(whole, t, kCapacity));
  }
}

TEST_CASE("ObservedStates: without hips the reference frame is kept; hips start it",
          "[core][observe]") {
  core::MarkerMotion motion = PointMotion(30, 2, 1);
  Hide(motion, 0, 0, 5);
  Hide(motion, 1, 10, 20);
  core::ObservedStates states = Empty();
  for (int t = 0; t < 20; ++t) {
    CHECK(states.Push(motion.positions_m.row(t)) == (t >= 5));
  }
  CHECK(states.next() == 15);
  const core::StateSequence last = states.Last(15);
  for (int t = 5; t < 15; ++t) CHECK(last.root_path.row(t) == last.root_path.row(4));
  // World position of the marker in the kept reference frame.
  const core::FrameMatrix world = core::WorldPositions(last);
  CHECK((world.row(14).segment<3>(9) - motion.positions_m.row(19).segment<3>(9)).norm() < 1e-4F);
  // Hips one above the other do not define the front.
  core::ObservedStates upright = Empty();
  motion.positions_m.row(25).segment<3>(0) =
      motion.positions_m.row(25).segment<3>(3) + Eigen::RowVector3f(0, 0, 0.2F);
  CHECK_FALSE(upright.Push(motion.positions_m.row(25)));
}

}  // namespace motiondb::tests::observed_states_test
