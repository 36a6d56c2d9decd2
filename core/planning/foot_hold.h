// How a foot must be shifted on the floor to stay in its place while it stands. Safe to call from
// any thread.
#pragma once

#include "core/planning/contacts.h"

namespace motiondb::core {

// frames x 2, m: along the world's x and y.
using FloorShift = Eigen::Array<double, Eigen::Dynamic, 2>;

// The shift of a foot in each frame. `contacts`: its own columns. While it stands, the shift undoes
// the way of the contact marker that moves least; between, it is eased to what comes next, or to
// none. It has no jump in position, velocity or acceleration. O(frames).
FloorShift HoldFoot(const Foot& foot, const ContactMatrix& contacts, double frame_rate_hz,
                    double leg_length_m, const FrameMatrix& positions_m);

}  // namespace motiondb::core
