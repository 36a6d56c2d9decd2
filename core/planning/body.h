// The body that plays a plan: a skeleton with the scheme's markers, or markers of a given size.
// Immutable.
//
// Stored motion is scaled to the body's leg length (hip to knee to ankle). Beyond that, skeletons
// of people rely on inverse kinematics. Robots have contact markers on flat soles: the stored
// feet's motion is transferred to their soles, which stand on z = 0.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/motion/marker_set.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// The markers of one foot (3 x foot_markers, in order) when standing flat: origin on the floor
// below the middle of its contact markers, x from the rear one to the front one, z up.
using FootShape = Eigen::Matrix3Xd;

class Body {
 public:
  // Markers without a skeleton.
  static Body OfSize(const Model& model, double leg_length_m);
  // INVALID_ARGUMENT if no mapping of the scheme fits the skeleton or its leg length is 0.
  static absl::StatusOr<Body> OfSkeleton(const Model& model, const MarkerScheme& scheme,
                                         std::shared_ptr<const Skeleton> skeleton, bool flat_soles);

  // Leg length (m) that plans are scaled to; a skeleton's at zero angles.
  double leg_length_m() const { return leg_length_m_; }
  const std::optional<MarkerKinematics>& kinematics() const { return kinematics_; }
  // The feet of this body.
  const Feet& feet() const { return feet_; }
  // The feet of the stored subjects, for their contacts.
  const Feet& stored_feet() const { return stored_feet_; }

  // Fits markers (frames x 3 N_v, m) of stored motion, already scaled to the leg length, to the
  // body's soles. No effect without flat soles.
  void Fit(FrameMatrix& positions_m) const;

 private:
  Body(const Model& model, double leg_length_m)
      : leg_length_m_(leg_length_m), stored_feet_(FindFeet(model)), feet_(stored_feet_) {}

  double leg_length_m_;
  Feet stored_feet_;
  Feet feet_;
  std::optional<MarkerKinematics> kinematics_;
  std::vector<FootShape> stored_shapes_;  // empty without flat soles
  std::vector<FootShape> soles_;
};

}  // namespace motiondb::core
