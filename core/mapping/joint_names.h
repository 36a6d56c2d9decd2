// Meaning of joint and marker names: side of the body, and the roles that a name may stand for.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace motiondb::core {

// Points of a body that mappings need. All from kHip on occur on both sides.
enum class Role {
  kPelvis,
  kSpine,  // any joint between pelvis and neck
  kNeck,   // base of the neck
  kHead,   // base of the skull
  kHeadTop,
  kNose,
  kHip,
  kKnee,
  kAnkle,
  kHeel,
  kToe,  // ball of the foot
  kToeTip,
  kClavicle,
  kShoulder,
  kElbow,
  kWrist,
  kHand,  // knuckles
  kEye,
  kEar,
  kCount,
};

inline constexpr std::size_t kRoleCount = static_cast<std::size_t>(Role::kCount);

enum class Side { kNone, kLeft, kRight };

struct NameMeaning {
  Side side = Side::kNone;
  // How well the name fits each role, 0 to 1. Several roles for ambiguous words: "shoulder" is the
  // clavicle or the shoulder joint, "leg" the shank or the whole leg.
  std::array<float, kRoleCount> fit{};
  // Helper, finger, face, hair, cloth or prop: no link of the figure.
  bool is_accessory = false;

  float fit_for(Role role) const { return fit[static_cast<std::size_t>(role)]; }
};

// Returns the meaning of each name of one file. Prefixes such as "mixamorig:" or "Bip01 " do not
// matter: words that most names share mean nothing.
std::vector<NameMeaning> NameMeanings(const std::vector<std::string>& names);

// Returns the words of each name of one file, without the words that most names begin with.
std::vector<std::vector<std::string>> WordsWithoutPrefix(const std::vector<std::string>& names);

// Returns the words of a name in lower case: "mixamorig:LeftUpLeg" -> left, up, leg;
// "CC_Base_L_Thigh" -> cc, base, l, thigh; "lfemur" -> l, femur; "Spine1" -> spine, 1.
std::vector<std::string> NameWords(std::string_view name);

}  // namespace motiondb::core
