// Real clips as states, for tests on real data.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/format/motion_file.h"
#include "core/model/model_builder.h"
#include "core/motion/states.h"

namespace motiondb::tests {

// Reads a motion file; an AMC's skeleton is the ASF beside it with the longest name that begins the
// AMC's. Fails the test on an error.
core::MotionFile LoadMotion(const std::filesystem::path& path);

// The states of a file on the standard markers.
core::StateSequence LoadStates(const std::filesystem::path& path, double frame_rate_hz,
                               core::Gaps gaps = core::Gaps::kFill);

struct ListedClip {
  std::filesystem::path path;
  std::string label;
};

// The rows of a clip list (columns path and label, paths relative to the list).
std::vector<ListedClip> ReadList(const std::filesystem::path& list);

// A model of a whole list on the standard markers.
core::Model BuildFromList(const std::filesystem::path& list, const core::BuildSettings& settings);

}  // namespace motiondb::tests
