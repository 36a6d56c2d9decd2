#include "core/mapping/skin_markers.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <unordered_map>

namespace motiondb::core {
namespace {

// Labels without side, lower-case letters and digits. Sources: the marker sets of
// docs/file_formats.md.
const std::unordered_map<std::string_view, Landmark>& Labels() {
  using enum Landmark;
  static const std::unordered_map<std::string_view, Landmark> labels = {
      {"sacr", kSacrum},
      {"sacrum", kSacrum},
      {"sac", kSacrum},
      {"vsacral", kSacrum},
      {"sacral", kSacrum},
      {"waistback", kSacrum},
      {"mbwt", kSacrum},
      {"s1", kSacrum},
      {"c7", kC7},
      {"cv7", kC7},
      {"backtop", kC7},
      {"spinetop", kC7},
      {"t2", kC7},
      {"tv2", kC7},
      {"spinethoracic2", kC7},
      {"t10", kT10},
      {"tv10", kT10},
      {"t8", kT10},
      {"t12", kT10},
      {"tv12", kT10},
      {"spinethoracic12", kT10},
      {"mai", kT10},
      {"tv7", kT10},
      {"clav", kClav},
      {"ij", kClav},
      {"sjn", kClav},
      {"sternum", kClav},
      {"manubrium", kClav},
      {"strn", kStrn},
      {"ster", kStrn},
      {"px", kStrn},
      {"sxs", kStrn},
      {"xyph", kStrn},
      {"xiph", kStrn},
      {"chest", kStrn},
      {"chestlow", kStrn},
      {"headfront", kForehead},
      {"frontofhead", kForehead},
      {"fronthead", kForehead},
      {"fhead", kForehead},
      {"rearhead", kBackOfHead},
      {"backhead", kBackOfHead},
      {"headback", kBackOfHead},

      {"asi", kAsis},
      {"asis", kAsis},
      {"ias", kAsis},
      {"fwt", kAsis},
      {"waistfront", kAsis},
      {"psi", kPsis},
      {"psis", kPsis},
      {"ips", kPsis},
      {"bwt", kPsis},
      {"waistrear", kPsis},
      {"kne", kKneeOut},
      {"knee", kKneeOut},
      {"kneeout", kKneeOut},
      {"kneelat", kKneeOut},
      {"kneelateral", kKneeOut},
      {"lek", kKneeOut},
      {"le", kKneeOut},
      {"fle", kKneeOut},
      {"flek", kKneeOut},
      {"knm", kKneeIn},
      {"kni", kKneeIn},
      {"mkne", kKneeIn},
      {"knem", kKneeIn},
      {"kneein", kKneeIn},
      {"kneemed", kKneeIn},
      {"kneemedial", kKneeIn},
      {"mek", kKneeIn},
      {"me", kKneeIn},
      {"fme", kKneeIn},
      {"ank", kAnkleOut},
      {"ankle", kAnkleOut},
      {"ankleout", kAnkleOut},
      {"anklelat", kAnkleOut},
      {"anklelateral", kAnkleOut},
      {"lm", kAnkleOut},
      {"fal", kAnkleOut},
      {"med", kAnkleIn},
      {"mank", kAnkleIn},
      {"ankm", kAnkleIn},
      {"ani", kAnkleIn},
      {"anklein", kAnkleIn},
      {"anklemed", kAnkleIn},
      {"anklemedial", kAnkleIn},
      {"mm", kAnkleIn},
      {"tam", kAnkleIn},
      {"hee", kHeel},
      {"hel", kHeel},
      {"heel", kHeel},
      {"heelback", kHeel},
      {"ca", kHeel},
      {"fcc", kHeel},
      {"toe", kToe},
      {"toetip", kToe},
      {"mt2", kToe},
      {"sm", kToe},
      {"fm2", kToe},
      {"forefoot2", kToe},
      {"mt1", kBigToe},
      {"fm1", kBigToe},
      {"fm", kBigToe},
      {"toein", kBigToe},
      {"forefootin", kBigToe},
      {"forefoot1", kBigToe},
      {"mt5", kSmallToe},
      {"fm5", kSmallToe},
      {"vm", kSmallToe},
      {"toeout", kSmallToe},
      {"forefootout", kSmallToe},
      {"forefoot5", kSmallToe},
      {"sho", kShoulder},
      {"shoulder", kShoulder},
      {"shouldertop", kShoulder},
      {"acromium", kShoulder},
      {"acromion", kShoulder},
      {"ac", kShoulder},
      {"acr", kShoulder},
      {"caj", kShoulder},
      {"fsh", kShoulder},
      {"upa", kUpperArm},
      {"uarmhigh", kUpperArm},
      {"bicep", kUpperArm},
      {"delt", kUpperArm},
      {"ua", kUpperArm},
      {"elb", kElbowOut},
      {"elbow", kElbowOut},
      {"elbowout", kElbowOut},
      {"lee", kElbowOut},
      {"lhe", kElbowOut},
      {"hle", kElbowOut},
      {"ael", kElbowOut},
      {"elbowlat", kElbowOut},
      {"elbowlateral", kElbowOut},
      {"iel", kElbowIn},
      {"elbowin", kElbowIn},
      {"mee", kElbowIn},
      {"mhe", kElbowIn},
      {"hme", kElbowIn},
      {"elbowmed", kElbowIn},
      {"elbowmedial", kElbowIn},
      {"elbm", kElbowIn},
      {"wra", kWristThumb},
      {"iwr", kWristThumb},
      {"lw", kWristThumb},
      {"rs", kWristThumb},
      {"rsp", kWristThumb},
      {"wts", kWristThumb},
      {"wristin", kWristThumb},
      {"wristlat", kWristThumb},
      {"wrb", kWristPinky},
      {"owr", kWristPinky},
      {"mw", kWristPinky},
      {"us", kWristPinky},
      {"usp", kWristPinky},
      {"wps", kWristPinky},
      {"wristout", kWristPinky},
      {"wristmed", kWristPinky},
      {"fin", kHand},
      {"hand", kHand},
      {"hand2", kHand},
      {"hm2", kHand},
      {"mid0", kHand},
      {"hts", kHandIn},
      {"ihand", kHandIn},
      {"handin", kHandIn},
      {"hps", kHandOut},
      {"ohand", kHandOut},
      {"handout", kHandOut},
      {"fhd", kHeadFront},
      {"ah", kHeadFront},
      {"bhd", kHeadBack},
      {"ph", kHeadBack},
      {"headside", kHeadSide},
  };
  return labels;
}

struct SidedLabel {
  Side side = Side::kNone;
  Landmark landmark = Landmark::kCount;
};

bool IsMiddle(Landmark landmark) { return landmark < Landmark::kAsis; }

std::optional<Landmark> Find(std::string_view label, bool is_sided) {
  // "WaistBack" is the sacrum, "WaistLBack" the left back; "HeadL" is beside "HeadFront".
  if (is_sided && label == "waistback") return Landmark::kPsis;
  if (is_sided && label == "head") return Landmark::kHeadSide;
  const auto found = Labels().find(label);
  if (found == Labels().end() || IsMiddle(found->second) == is_sided) return std::nullopt;
  return found->second;
}

Side SideOf(std::string_view word) {
  if (word == "l" || word == "left") return Side::kLeft;
  if (word == "r" || word == "right") return Side::kRight;
  return Side::kNone;
}

SidedLabel ReadLabel(const std::vector<std::string>& words) {
  std::string all;
  std::string rest;  // without the word of the side
  Side side = Side::kNone;
  for (const std::string& word : words) {
    all += word;
    const Side of_word = SideOf(word);
    if (side == Side::kNone && of_word != Side::kNone) {
      side = of_word;
    } else {
      rest += word;
    }
  }
  if (const auto landmark = Find(all, false)) return {Side::kNone, *landmark};
  if (side != Side::kNone) {
    if (const auto landmark = Find(rest, true)) return {side, *landmark};
  }
  // "LASI", "ASIL".
  if (all.size() < 3) return {};
  const std::string_view text = all;
  if (const Side first = SideOf(text.substr(0, 1)); first != Side::kNone) {
    if (const auto landmark = Find(text.substr(1), true)) return {first, *landmark};
  }
  if (const Side last = SideOf(text.substr(text.size() - 1)); last != Side::kNone) {
    if (const auto landmark = Find(text.substr(0, text.size() - 1), true)) return {last, *landmark};
  }
  return {};
}

}  // namespace

SkinMarkers::SkinMarkers(const std::vector<std::string>& labels) {
  for (auto& sides : points_) sides.fill(-1);
  const auto words = WordsWithoutPrefix(labels);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const SidedLabel label = ReadLabel(words[i]);
    if (label.landmark == Landmark::kCount) continue;
    int& point = points_[static_cast<std::size_t>(label.landmark)][label.side == Side::kRight];
    if (point < 0) point = static_cast<int>(i);
  }
}

PointSum SkinMarkers::at(Landmark landmark, Side side) const {
  const bool right = side == Side::kRight && !IsMiddle(landmark);
  const int point = points_[static_cast<std::size_t>(landmark)][right];
  return point < 0 ? PointSum{} : PointSum{{point, 1}};
}

int SkinMarkers::count() const {
  int found = 0;
  for (const auto& sides : points_) {
    found += static_cast<int>(std::ranges::count_if(sides, [](int point) { return point >= 0; }));
  }
  return found;
}

bool SkinMarkers::has_legs() const {
  using enum Landmark;
  return std::ranges::all_of(std::array{Side::kLeft, Side::kRight}, [&](Side side) {
    return !at(kAsis, side).empty() && !(at(kPsis, side).empty() && at(kSacrum).empty()) &&
           !at(kKneeOut, side).empty() && !at(kAnkleOut, side).empty();
  });
}

}  // namespace motiondb::core
