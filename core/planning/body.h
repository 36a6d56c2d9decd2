// Who is to play a plan: a skeleton with the scheme's markers on it, or bare markers of a size.
// Immutable; safe to share between threads.
//
// Stored motion is scaled to the body's leg length (hip to knee to ankle). A skeleton of people is
// left to inverse kinematics beyond that; a robot, whose contact markers are on flat soles, also
// gets the stored feet's motion on its own soles, which stand on z = 0.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/kinematics/marker_kinematics.h"
#include "core/motion/marker_set.h"
#include "core/planning/contacts.h"
#include "core/planning/foot_lock.h"

namespace motiondb::core {

class Body {
 public:
  // Bare markers.
  static Body OfSize(const Model& model, double leg_length_m);
  // INVALID_ARGUMENT if no mapping of the scheme fits the skeleton or its legs have no length.
  static absl::StatusOr<Body> OfSkeleton(const Model& model, const MarkerScheme& scheme,
                                         std::shared_ptr<const Skeleton> skeleton, bool flat_soles);

  // The size that a plan is scaled to, with all angles zero.
  double leg_length_m() const { return leg_length_m_; }
  const std::optional<MarkerKinematics>& kinematics() const { return kinematics_; }
  // The feet as they are on this body.
  const Feet& feet() const { return feet_; }
  // The feet as they are on the stored subjects, whose contacts they tell.
  const Feet& stored_feet() const { return stored_feet_; }

  // Brings markers (frames x 3 N_v, m) of stored motion, already of the body's leg length, to its
  // soles. Nothing changes on a body without flat ones.
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
