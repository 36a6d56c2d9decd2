#include "core/motion/mirror.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::mirror_test {

TEST_CASE("OtherSides: sides are deduced from names", "[core][motion]") {
  CHECK(core::OtherSides({"Pelvis", "LHip", "RHip", "LowerBack", "LeftFoot", "RightFoot"}) ==
        std::vector<int>{0, 2, 1, 3, 5, 4});
  CHECK(core::OtherSides({"LHand", "Head"}).empty());
  CHECK(core::OtherSides({"left_knee", "right_knee", "l_toe", "r_toe"}) ==
        std::vector<int>{1, 0, 3, 2});
  CHECK(core::OtherSides({}).empty());
}

TEST_CASE("MirrorStates: exchanges left and right; applied twice it is the identity",
          "[core][motion]") {
  const std::vector<int> sides = core::OtherSides({"LHip", "Head", "RHip"});
  core::FrameMatrix states = core::FrameMatrix::Random(4, 18);
  const core::FrameMatrix mirrored = core::MirrorStates(sides, states);
  CHECK(mirrored(2, 0) == states(2, 12));
  CHECK(mirrored(2, 1) == -states(2, 13));
  CHECK(mirrored(2, 3) == states(2, 15));
  CHECK(mirrored(2, 16) == -states(2, 4));
  CHECK(mirrored(1, 6) == states(1, 6));
  CHECK(mirrored(1, 7) == -states(1, 7));
  CHECK(core::MirrorStates(sides, mirrored) == states);
  const core::FrameMatrix positions = core::FrameMatrix::Random(2, 9);
  CHECK(core::MirrorPositions(sides, core::MirrorPositions(sides, positions)) == positions);
}

}  // namespace motiondb::tests::mirror_test
