#include "core/kinematics/marker_kinematics.h"
#include "tests/core/kinematics/figure.h"

namespace motiondb::tests::joint_limits_test {

TEST_CASE("CountLimitViolations: counts degrees of freedom beyond a limit over all frames",
          "[core][kinematics]") {
  const auto skeleton = Figure();
  core::JointMotion motion = Swing(skeleton, 10);
  CHECK(core::CountLimitViolations(motion, 0) == 0);
  const int knee = skeleton->first_dof(skeleton->FindJoint("lknee"));
  motion.angles(2, knee) = 2.51;   // of 2.5
  motion.angles(3, knee) = 0.03;   // of 0.05
  motion.angles(3, knee + 1) = 7;  // of 1
  motion.angles(4, 0) = 1e9;       // the root has no limits
  CHECK(core::CountLimitViolations(motion, 0) == 3);
  CHECK(core::CountLimitViolations(motion, 0.015) == 2);
  CHECK(core::CountLimitViolations(motion, 0.1) == 1);
  SECTION("NaN is beyond limits") {
    motion.angles(9, 0) = std::nan("");
    CHECK(core::CountLimitViolations(motion, 0.1) == 2);
  }
}

}  // namespace motiondb::tests::joint_limits_test
