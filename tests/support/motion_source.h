// Real clips from files, with errors as values. Safe to call from any thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::tests {

// The bytes of a file. NOT_FOUND if it cannot be read.
absl::StatusOr<std::string> ReadBytes(const std::filesystem::path& path);

// Reads a motion file. An AMC's skeleton is the ASF beside it with the longest name that begins the
// AMC's; NOT_FOUND if there is none.
absl::StatusOr<core::MotionFile> ReadMotion(const std::filesystem::path& path);

struct ListedClip {
  std::filesystem::path path;
  std::string label;
};

// The rows of a clip list (columns path and label, paths relative to the list).
absl::StatusOr<std::vector<ListedClip>> ReadClipList(const std::filesystem::path& list);

}  // namespace motiondb::tests
