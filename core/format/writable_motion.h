// What every writer of joint motion asks of it. Safe to call from any thread.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// INVALID_ARGUMENT, beginning with `format`, if the motion has no skeleton, no frame, a frame rate
// out of 0.001 to 100000 Hz, columns other than the skeleton's degrees of freedom, or a number that
// is not finite.
absl::Status CheckWritable(std::string_view format, const JointMotion& motion);

}  // namespace motiondb::core
