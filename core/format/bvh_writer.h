// Joint motion -> a BVH file, as animators' tools read it. Safe to call from any thread.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// The motion as BVH text in centimetres, y up, on the skeleton's own joints, in depth-first order.
// Every joint has three rotation channels, whatever its degrees of freedom, as ZXY or ZYX: the one
// that stays further from gimbal lock over the clip; angles run on beyond 180 degrees rather than
// jump. A root, and a joint that slides, has three position channels too. A joint "x_end" without
// degrees of freedom that is the only child of x is written as its end site; any other joint
// without children gets an end site that goes on in the joint's own direction. White space,
// control characters and braces in names become '_'. O(frames * joints).
//
// Read back, joints are where they were to within a micrometre a joint of the chain.
//
// INVALID_ARGUMENT if the motion has no skeleton, no frame, a frame rate out of 0.001 to 100000 Hz,
// columns other than the skeleton's degrees of freedom, or a number that is not finite.
absl::StatusOr<std::string> WriteBvh(const JointMotion& motion);

}  // namespace motiondb::core
