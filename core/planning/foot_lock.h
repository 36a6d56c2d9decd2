// Keeps feet where they stand (section VI-E: "the feet occasionally slip and penetrate the floor").
// Safe to call from any thread.
#pragma once

#include "core/motion/matrix.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// Moves the markers of legs and feet (frames x 3 N_v, m, world) so that a foot stays in its place
// while it stands, and none of its contact markers is below its rest height; it eases into and out
// of that without a jump in position, velocity or acceleration.
//
// A foot keeps its shape and its direction: it is shifted, so that of the markers that stand
// together the one that moves least stays where it is (foot_hold.h). The knee follows in the leg's
// own plane; thigh and shin keep their lengths, and what lies along them goes with them. The whole
// body is raised or lowered smoothly, by some millimetres, so that straight legs reach their feet.
// All other markers keep their places against the hips. leg_length_m: the subject's. No marker may
// be missing. O(frames * markers).
void LockFeet(const Feet& feet, const ContactMatrix& contacts, double frame_rate_hz,
              double leg_length_m, FrameMatrix& positions_m);

}  // namespace motiondb::core
