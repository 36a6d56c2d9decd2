// Names of a skeleton's degrees of freedom, as plans give them. Safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "core/motion/skeleton.h"

namespace motiondb::server {

// One for each column of a frame of joint angles: the joint's name where that is its only degree of
// freedom, else "joint.tx" or "joint.rx" and so on, after the axis that it is nearest to; with a
// number, "joint.rz2", for another about the same axis.
std::vector<std::string> DofNames(const core::Skeleton& skeleton);

}  // namespace motiondb::server
