// The contract of a motion from a reader.
#pragma once

#include "core/format/motion_file.h"
#include "core/motion/states.h"

namespace motiondb::tests {

// Shapes agree, values are finite (a missing marker is NaN in all three), names are distinct.
void CheckMotion(const core::Motion& motion);

// Checks the result of a reader of motion files: the error, or the motion and the states that a
// database with the motion's own markers computes.
void CheckMotionFile(const absl::StatusOr<core::MotionFile>& read);

}  // namespace motiondb::tests
