// Joint centres from the markers around them.
#include <array>
#include <initializer_list>

#include "core/mapping/skin_markers.h"

namespace motiondb::core {
namespace {

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
    markers["Waist"] = Between(waist_, thorax_, 0.5);
    markers["Spine"] = Between(waist_, thorax_, 0.95);
    markers["Neck"] = Between(thorax_, neck_, 0.6);
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
    const PointSum knee = Centre(kKneeOut, kKneeIn, side, 0.34);
    const PointSum ankle = Centre(kAnkleOut, kAnkleIn, side, 0.22);
    const PointSum knees =
        Middle(skin_.at(kKneeOut, Side::kLeft), skin_.at(kKneeOut, Side::kRight));
    const PointSum& base = hip_base_[side == Side::kRight];
    const PointSum hip = thorax_.empty()
                             ? Total({{1, base}, {kHipShare, knees}, {-kHipShare, waist_}})
                             : Total({{1, base}, {0.47, waist_}, {-0.47, thorax_}});
    const PointSum toe = FirstOf({Middle(at(kBigToe), at(kSmallToe)),
                                  Inwards(Between(at(kToe), at(kSmallToe), 0.3), side, 0.1),
                                  at(kToe), at(kBigToe), at(kSmallToe)});
    markers[s + "Hip"] = hip;
    markers[s + "Knee"] = knee;
    markers[s + "Ankle"] = ankle;
    markers[s + "Toe"] = toe;
    markers[s + "Heel"] = FirstOf({at(kHeel), Total({{1.37, ankle}, {-0.12, knee}, {-0.25, toe}})});
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

std::map<std::string, PointSum> StandardMarkers(const SkinMarkers& skin) {
  if (!skin.has_legs()) return {};
  return SkinToStandard(skin).All();
}

}  // namespace motiondb::core
