#include "core/mapping/joint_names.h"

#include <catch2/catch.hpp>

namespace motiondb::tests::joint_names_test {
namespace {

using core::NameMeaning;
using core::Role;
using core::Side;
using Words = std::vector<std::string>;

NameMeaning Meaning(const std::string& name) { return core::NameMeanings({name})[0]; }

TEST_CASE("NameWords: divides the spellings of tools", "[core][mapping]") {
  CHECK(core::NameWords("mixamorig:LeftUpLeg") == Words{"left", "up", "leg"});
  CHECK(core::NameWords("CC_Base_L_Thigh") == Words{"cc", "base", "l", "thigh"});
  CHECK(core::NameWords("lfemur") == Words{"l", "femur"});
  CHECK(core::NameWords("lowerback") == Words{"lower", "back"});
  CHECK(core::NameWords("Bip01 L UpperArm") == Words{"bip", "01", "l", "upper", "arm"});
  CHECK(core::NameWords("LUArm") == Words{"l", "u", "arm"});
  CHECK(core::NameWords("DEF-spine.001") == Words{"def", "spine", "001"});
  CHECK(core::NameWords("T12") == Words{"spine"});
  CHECK(core::NameWords("").empty());
  CHECK(core::NameWords(":::").empty());
}

TEST_CASE("NameMeanings: finds sides and roles", "[core][mapping]") {
  struct Case {
    const char* name;
    Side side;
    Role role;
  };
  for (const auto& [name, side, role] :
       {Case{"thigh_l", Side::kLeft, Role::kHip}, Case{"RightLeg", Side::kRight, Role::kKnee},
        Case{"lShin", Side::kLeft, Role::kKnee}, Case{"upperarm_r", Side::kRight, Role::kShoulder},
        Case{"HipLeft", Side::kLeft, Role::kHip}, Case{"Hips", Side::kNone, Role::kPelvis},
        Case{"hip", Side::kNone, Role::kPelvis}, Case{"LFArm", Side::kLeft, Role::kElbow},
        Case{"SpineShoulder", Side::kNone, Role::kNeck},
        Case{"HeadTop_End", Side::kNone, Role::kHeadTop},
        Case{"Head_end", Side::kNone, Role::kHeadTop},
        Case{"left_foot_index", Side::kLeft, Role::kToeTip},
        Case{"LSx_joint", Side::kLeft, Role::kShoulder}}) {
    CAPTURE(name);
    const NameMeaning meaning = Meaning(name);
    CHECK(meaning.side == side);
    for (std::size_t r = 0; r < core::kRoleCount; ++r) {
      CHECK(meaning.fit[r] <= meaning.fit_for(role));
    }
    CHECK(meaning.fit_for(role) > 0.5F);
  }
}

TEST_CASE("NameMeanings: accessories have no role", "[core][mapping]") {
  for (const char* const name : {"lowerarm_twist_01_l", "LeftHandThumb1", "hair_03", "ik_foot_l",
                                 "J_Sec_L_Bust1", "Prop1", "LeftEye", "jaw"}) {
    CAPTURE(name);
    const NameMeaning meaning = Meaning(name);
    CHECK(meaning.is_accessory);
    CHECK(meaning.fit_for(Role::kElbow) + meaning.fit_for(Role::kWrist) +
              meaning.fit_for(Role::kAnkle) ==
          0);
  }
}

TEST_CASE("NameMeanings: ambiguous names are decided by the others of their side",
          "[core][mapping]") {
  const auto thigh = core::NameMeanings({"LeftUpLeg", "LeftLeg", "LeftShoulder", "LeftArm"});
  CHECK(thigh[1].fit_for(Role::kKnee) > thigh[1].fit_for(Role::kHip));
  CHECK(thigh[2].fit_for(Role::kClavicle) > thigh[2].fit_for(Role::kShoulder));
  const auto shin = core::NameMeanings({"LeftLeg", "LeftShin", "LeftShoulder", "LeftElbow"});
  CHECK(shin[0].fit_for(Role::kHip) > shin[0].fit_for(Role::kKnee));
  CHECK(shin[2].fit_for(Role::kShoulder) > shin[2].fit_for(Role::kClavicle));
  const auto kinect = core::NameMeanings({"AnkleLeft", "FootLeft", "WristLeft", "HandLeft"});
  CHECK(kinect[1].fit_for(Role::kToe) > kinect[1].fit_for(Role::kAnkle));
  CHECK(kinect[3].fit_for(Role::kHand) > kinect[3].fit_for(Role::kWrist));
}

}  // namespace
}  // namespace motiondb::tests::joint_names_test
