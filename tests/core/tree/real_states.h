// Recorded motion as input of the tree build.
#pragma once

#include <functional>
#include <string>

#include "core/motion/matrix.h"
#include "tests/support/motion_source.h"

namespace motiondb::tests {

// Returns the scaled states of the selected clips of a list (frames x dimensions) on the standard
// markers. Fails the test on an error.
core::FrameMatrix LoadScaledStates(
    const std::string& list, double frame_rate_hz,
    const std::function<bool(const ListedClip&)>& wanted = [](const ListedClip&) { return true; });

inline bool IsHdm05(const ListedClip& clip) {
  return clip.path.string().find("hdm05") != std::string::npos;
}

}  // namespace motiondb::tests
