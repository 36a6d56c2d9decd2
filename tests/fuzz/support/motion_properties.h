// What a motion that a reader took is promised to be. Safe to call from any thread.
#pragma once

#include "core/format/motion_file.h"
#include "core/motion/states.h"

namespace motiondb::tests {

// Shapes agree, numbers are finite (a missing marker is NaN in all three), names are distinct.
void HoldsMotion(const core::Motion& motion);

// The whole check of a reader of motion files: the error or the motion, and the states that a
// database with the motion's own markers would make of it.
void HoldsMotionFile(const absl::StatusOr<core::MotionFile>& read);

}  // namespace motiondb::tests
