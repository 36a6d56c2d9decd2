// Keeps feet where they stand (section VI-E: "the feet occasionally slip and penetrate the floor").
// Safe to call from any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/kinematics/marker_kinematics.h"
#include "core/motion/matrix.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// Moves the markers of legs and feet (frames x 3 N_v, m, world) so that a foot stays in its place
// while it stands, and none of its contact markers is below its rest height; it eases into and out
// of that without a jump in position, velocity or acceleration.
//
// A foot keeps its shape and its direction: it is shifted, so that of the markers that stand
// together the one that moves least stays where it is (HoldFoot). The knee follows in the leg's
// own plane; thigh and shin keep their lengths, and what lies along them goes with them. The whole
// body is raised or lowered smoothly, by some millimetres, so that straight legs reach their feet.
// All other markers keep their places against the hips. leg_length_m: the subject's. No marker may
// be missing. O(frames * markers).
void LockFeet(const Feet& feet, const ContactMatrix& contacts, double frame_rate_hz,
              double leg_length_m, FrameMatrix& positions_m);

// frames x 2, m: along the world's x and y.
using FloorShift = Eigen::Array<double, Eigen::Dynamic, 2>;

// The shift of a foot in each frame. `contacts`: its own columns. While it stands, the shift undoes
// the way of the contact marker that moves least; between, it is eased to what comes next, or to
// none. It has no jump in position, velocity or acceleration. O(frames).
FloorShift HoldFoot(const Foot& foot, const ContactMatrix& contacts, double frame_rate_hz,
                    double leg_length_m, const FrameMatrix& positions_m);

// Standing on another foot: how a stored foot's motion is played by a body whose soles are its own.
// Safe to call from any thread.

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
