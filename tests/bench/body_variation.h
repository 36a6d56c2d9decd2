// Varies the body and the manner of a recorded pose: limb sizes, posture, reach of movements, and a
// slow sway. Seeded.
#pragma once

#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/planning/seeded.h"

namespace motiondb::tests {

// A marker and its parent marker; parents come first.
struct Bone {
  int marker = 0;
  int parent = 0;
  int limb = 0;  // in [0, kLimbs)
};

inline constexpr int kLimbs = 7;  // hips, trunk, head, arms, legs

// Returns the tree of the standard markers. INVALID_ARGUMENT if the set lacks one.
absl::StatusOr<std::vector<Bone>> StandardBones(const core::MarkerSet& set);

// A smooth function of time in [-1, 1]: three slow sinusoids.
class Wave {
 public:
  explicit Wave(core::SeededSequence& random);
  double At(double seconds) const;

 private:
  double cycles_per_second_[3];
  double phase_[3];
};

class BodyVariation {
 public:
  // `usual` and `other` are mean poses (1 x 3 N_v, reference frame): that of the clip, and the one
  // whose posture is mixed in.
  BodyVariation(std::vector<Bone> bones, const Eigen::RowVectorXf& usual,
                const Eigen::RowVectorXf& other, core::SeededSequence& random);

  // Varies a pose (1 x 3 N_v, reference frame, leg lengths) in place. Bones keep their length times
  // the factor of their limb. Overwrites `scratch`.
  void Apply(double seconds, Eigen::RowVectorXf& pose, Eigen::RowVectorXf& scratch) const;

 private:
  struct Limb {
    float size = 1;   // factor of the length of its bones
    float reach = 1;  // factor of the deviation of its bones from their mean direction
    float sway_rad = 0;
    std::vector<Wave> sway;  // about x, y and z
  };

  std::vector<Bone> bones_;
  std::vector<Limb> limbs_;
  Eigen::Matrix3Xf lean_;  // offset of each bone (leg lengths)
};

}  // namespace motiondb::tests
