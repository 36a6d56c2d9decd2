// Standing on another foot: how a stored foot's motion is played by a body whose soles are its own.
// Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// The markers of one foot (3 x foot_markers, in their order) while it stands flat: origin on the
// floor below the middle of its contact markers, x from the rear one to the front one, z up.
using FootShape = Eigen::Matrix3Xd;

// The shapes of the stored feet in leg lengths, from frames in which they stand flat. Nothing where
// a foot has a single contact marker or never stands flat.
std::optional<std::vector<FootShape>> StoredFootShapes(const Model& model, const Feet& feet);

// The shapes of a skeleton's feet in m, with all angles zero, if it then stands on flat soles:
// contact markers level with each other, as robots have them. Nothing otherwise.
std::optional<std::vector<FootShape>> FlatSoles(const MarkerKinematics& kinematics,
                                                const MarkerSet& set, const Feet& feet,
                                                double leg_length_m);

// Puts a body's soles where the stored feet are (frames x 3 N_v, m): each foot keeps its direction
// and tilt and stands on the same points, and the rest of the body is as much lower or higher as
// the ankles are above other soles. `stored` in leg lengths, `soles` in m.
void StandOnSoles(const Feet& feet, const std::vector<FootShape>& stored, double leg_length_m,
                  const std::vector<FootShape>& soles, FrameMatrix& positions_m);

}  // namespace motiondb::core
