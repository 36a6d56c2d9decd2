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

PointSum Middle(const PointSum& a, const PointSum& b) { return Between(a, b, 0.5); }

// The first sum that is known.
PointSum FirstOf(std::initializer_list<PointSum> sums) {
  for (const PointSum& sum : sums) {
    if (!sum.empty()) return sum;
  }
  return {};
}

// Shares of the way from the waist's markers (0) to the base of the neck (1).
constexpr double kThoraxShare = 0.45;
// Without markers on the trunk, hips are below the waist's markers by this share of the way to the
// knees.
constexpr double kHipShare = 0.22;

class SkinToStandard {
 public:
  explicit SkinToStandard(const SkinMarkers& skin) : skin_(skin) {
    using enum Landmark;
    const auto back = [&](Side side) { return FirstOf({skin.at(kPsis, side), skin.at(kSacrum)}); };
    for (const Side side : {Side::kLeft, Side::kRight}) {
      pelvis_[side == Side::kRight] = Middle(skin.at(kAsis, side), back(side));
      hip_base_[side == Side::kRight] = Between(skin.at(kAsis, side), back(side), 0.25);
    }
    waist_ = Middle(pelvis_[0], pelvis_[1]);
    const PointSum shoulders =
        Middle(skin.at(kShoulder, Side::kLeft), skin.at(kShoulder, Side::kRight));
    neck_ = FirstOf({Middle(skin.at(kC7), skin.at(kClav)), shoulders});
    thorax_ =
        FirstOf({Middle(skin.at(kT10), skin.at(kStrn)), Between(waist_, neck_, kThoraxShare)});
  }

  std::map<std::string, PointSum> All() const {
    using enum Landmark;
    std::map<std::string, PointSum> markers;
    markers["Waist"] = Between(waist_, thorax_, 0.4);
    markers["Spine"] = Between(waist_, thorax_, 0.85);
    markers["Neck"] = Between(thorax_, neck_, 0.42);
    markers["Head"] = Between(neck_, Head(), 0.39);
    markers["HeadTop"] = Between(neck_, Head(), 0.88);
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const std::string s = side == Side::kLeft ? "L" : "R";
      AddLeg(s, side, markers);
      AddArm(s, side, markers);
      markers[s + "Clavicle"] = Middle(markers["Neck"], markers[s + "Shoulder"]);
    }
    markers["Pelvis"] = Middle(markers["LHip"], markers["RHip"]);
    std::erase_if(markers, [](const auto& marker) { return marker.second.empty(); });
    return markers;
  }

 private:
  // Moves a marker on the outer side inwards by `share` of the distance of the pelvis's sides;
  // exactly between two markers if there is one on the inner side.
  PointSum Centre(Landmark out, Landmark in, Side side, double share) const {
    const PointSum outer = skin_.at(out, side);
    if (const PointSum inner = skin_.at(in, side); !inner.empty()) return Middle(outer, inner);
    return Inwards(outer, side, share);
  }

  PointSum Inwards(const PointSum& point, Side side, double share) const {
    const bool right = side == Side::kRight;
    return Total({{1, point}, {-share, pelvis_[right]}, {share, pelvis_[!right]}});
  }

  void AddLeg(const std::string& s, Side side, std::map<std::string, PointSum>& markers) const {
    using enum Landmark;
    const auto at = [&](Landmark landmark) { return skin_.at(landmark, side); };
    const PointSum knee = Centre(kKneeOut, kKneeIn, side, 0.5);
    const PointSum ankle = Centre(kAnkleOut, kAnkleIn, side, 0.5);
    const PointSum knees =
        Middle(skin_.at(kKneeOut, Side::kLeft), skin_.at(kKneeOut, Side::kRight));
    const PointSum& base = hip_base_[side == Side::kRight];
    const PointSum hip = thorax_.empty()
                             ? Total({{1, base}, {kHipShare, knees}, {-kHipShare, waist_}})
                             : Total({{1, base}, {0.47, waist_}, {-0.47, thorax_}});
    const PointSum toe = FirstOf({Middle(at(kBigToe), at(kSmallToe)),
                                  Inwards(Between(at(kToe), at(kSmallToe), 0.3), side, 0.3),
                                  at(kToe), at(kBigToe), at(kSmallToe)});
    markers[s + "Hip"] = hip;
    markers[s + "Knee"] = knee;
    markers[s + "Ankle"] = ankle;
    markers[s + "Toe"] = toe;
    markers[s + "Heel"] = FirstOf(
        {Inwards(at(kHeel), side, 0.2), Total({{1.37, ankle}, {-0.12, knee}, {-0.25, toe}})});
    markers[s + "Thigh"] = Middle(hip, knee);
    markers[s + "Shin"] = Middle(knee, ankle);
  }

  void AddArm(const std::string& s, Side side, std::map<std::string, PointSum>& markers) const {
    using enum Landmark;
    const auto at = [&](Landmark landmark) { return skin_.at(landmark, side); };
    const PointSum elbow = Centre(kElbowOut, kElbowIn, side, 0.3);
    const PointSum shoulder =
        FirstOf({Between(at(kShoulder), at(kUpperArm), 0.22), Between(at(kShoulder), elbow, 0.11)});
    const PointSum wrist =
        FirstOf({Middle(at(kWristThumb), at(kWristPinky)), at(kWristThumb), at(kWristPinky)});
    markers[s + "Shoulder"] = shoulder;
    markers[s + "Elbow"] = elbow;
    markers[s + "Wrist"] = wrist;
    markers[s + "Hand"] =
        FirstOf({at(kHand), Middle(at(kHandIn), at(kHandOut)), Between(elbow, wrist, 1.25)});
    markers[s + "UpperArm"] = Middle(shoulder, elbow);
    markers[s + "Forearm"] = Middle(elbow, wrist);
  }

  // Middle of the head at the height of the forehead.
  PointSum Head() const {
    using enum Landmark;
    const auto both = [&](Landmark landmark) {
      return Middle(skin_.at(landmark, Side::kLeft), skin_.at(landmark, Side::kRight));
    };
    return FirstOf({Middle(both(kHeadFront), both(kHeadBack)), both(kHeadSide),
                    Middle(skin_.at(kForehead), skin_.at(kBackOfHead))});
  }

  const SkinMarkers& skin_;
  std::array<PointSum, 2> pelvis_;    // middle of the waist's markers of a side
  std::array<PointSum, 2> hip_base_;  // above a hip, at the height of the waist's markers
  PointSum waist_;
  PointSum thorax_;  // inside the chest, above the lower end of the breastbone
  PointSum neck_;
};

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

std::map<std::string, PointSum> StandardMarkers(const SkinMarkers& skin) {
  if (!skin.has_legs()) return {};
  return SkinToStandard(skin).All();
}

}  // namespace motiondb::core
