// Recorded clips as states.
#pragma once

#include <filesystem>
#include <vector>

#include "core/model/model_builder.h"
#include "core/motion/states.h"
#include "tests/support/motion_source.h"

namespace motiondb::tests {

// ReadMotion; fails the test on an error.
core::MotionFile LoadMotion(const std::filesystem::path& path);

// Returns the states of a file on the standard markers.
core::StateSequence LoadStates(const std::filesystem::path& path, double frame_rate_hz,
                               core::Cleaning cleaning = core::GlitchPolicy::kRepair);

// ReadClipList; fails the test on an error.
std::vector<ListedClip> ReadList(const std::filesystem::path& list);

// Builds a model of all clips of a list on the standard markers.
core::Model BuildFromList(const std::filesystem::path& list, const core::BuildSettings& settings);

}  // namespace motiondb::tests
