// Optical markers on the skin: which label is at which anatomical landmark.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/mapping/joint_names.h"
#include "core/mapping/point_sum.h"

namespace motiondb::core {

// Landmarks of optical marker sets. All from kAsis on occur on both sides.
enum class Landmark {
  kSacrum,
  kC7,    // or the highest marker of the back
  kT10,   // back, below the shoulder blades
  kClav,  // upper end of the breastbone
  kStrn,  // lower end of the breastbone
  kForehead,
  kBackOfHead,
  kAsis,  // front of the waist
  kPsis,  // back of the waist
  kKneeOut,
  kKneeIn,
  kAnkleOut,
  kAnkleIn,
  kHeel,
  kToe,  // second metatarsal, or tip
  kBigToe,
  kSmallToe,
  kShoulder,
  kUpperArm,
  kElbowOut,
  kElbowIn,
  kWristThumb,
  kWristPinky,
  kHand,  // knuckle of the second or third finger
  kHandIn,
  kHandOut,
  kHeadFront,
  kHeadBack,
  kHeadSide,
  kCount,
};

// The labels of one motion by landmark.
class SkinMarkers {
 public:
  // Reads labels such as "LASI", "Subject:L_IAS", "WaistLFront", "R.Knee.Medial".
  explicit SkinMarkers(const std::vector<std::string>& labels);

  // Returns the label's point; empty if the motion lacks it. `side` is ignored for landmarks in the
  // middle.
  PointSum at(Landmark landmark, Side side = Side::kNone) const;
  // Number of landmarks found.
  int count() const;
  // True if the pelvis has markers in front and at the back, and each leg at knee and ankle: the
  // motion can be mapped.
  bool has_legs() const;

 private:
  std::array<std::array<int, 2>, static_cast<std::size_t>(Landmark::kCount)> points_;
};

// Returns the positions of the standard set's markers that the labels determine. Joint centres are
// inside the body: knees and ankles are moved inwards by half of the half pelvis's breadth if there
// is no marker on the inner side. The weights were fitted to Acclaim skeletons and optical markers
// of the same motion (CMU collection). Empty without SkinMarkers::has_legs.
std::map<std::string, PointSum> StandardMarkers(const SkinMarkers& skin);

}  // namespace motiondb::core
