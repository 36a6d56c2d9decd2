// Keeps standing feet in place (section VI-E: "the feet occasionally slip and penetrate the
// floor").
#pragma once

#include <Eigen/Core>

#include "core/motion/matrix.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// Moves the markers of legs and feet (frames x 3 N_v, m, world) so that a standing foot stays in
// place and no contact marker is below its rest height. Transitions are continuous in position,
// velocity and acceleration.
//
// A foot keeps its shape and direction. It is shifted so that, of the standing markers, the one
// that moves least is fixed (FootShift). The knee moves in the plane of the leg; thigh and shin
// keep their lengths and carry their markers. The whole body is smoothly raised or lowered by some
// millimetres, so that straight legs reach their feet. All other markers move with the hips.
// leg_length_m: the subject's. REQUIRES: no missing markers. O(frames * markers).
void LockFeet(const Feet& feet, const ContactMatrix& contacts, double frame_rate_hz,
              double leg_length_m, FrameMatrix& positions_m);

// frames x 2, m: along the world's x and y.
using FloorShift = Eigen::Array<double, Eigen::Dynamic, 2>;

// Returns the shift of a foot in each frame. `contacts`: the foot's columns. While the foot stands,
// the shift cancels the motion of the contact marker that moves least; between stances it is
// interpolated to the next one, or to zero. It is continuous in position, velocity and
// acceleration. O(frames).
FloorShift FootShift(const Foot& foot, const ContactMatrix& contacts, double frame_rate_hz,
                     double leg_length_m, const FrameMatrix& positions_m);

}  // namespace motiondb::core
