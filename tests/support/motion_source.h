// Reads recorded clips from files. Errors are returned as absl::Status.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"

namespace motiondb::tests {

// Returns the bytes of a file. NOT_FOUND if it cannot be read.
absl::StatusOr<std::string> ReadBytes(const std::filesystem::path& path);

// Reads a motion file. The skeleton of an AMC is the ASF in the same folder with the longest name
// that is a prefix of the AMC's name; NOT_FOUND if there is none.
absl::StatusOr<core::MotionFile> ReadMotion(const std::filesystem::path& path);

struct ListedClip {
  std::filesystem::path path;
  std::string label;
};

// Reads a clip list: columns path and label, paths relative to the list.
absl::StatusOr<std::vector<ListedClip>> ReadClipList(const std::filesystem::path& list);

}  // namespace motiondb::tests
