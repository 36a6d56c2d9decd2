// Lists of clips in a file: tab-separated, with a header line that names the columns. Pure
// functions.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

// One clip to ingest; empty fields are not given.
struct ClipEntry {
  std::filesystem::path path;
  std::string label;
  std::string subject;
  std::filesystem::path skeleton;
};

// Reads a list: columns `path` and `label`, where present `subject` and `skeleton`, in any order,
// and any others, which are ignored. Blank lines and lines that begin with '#' count for nothing.
// Relative paths are relative to the list file. INVALID_ARGUMENT names the file, the line and what
// was expected.
absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text);

}  // namespace motiondb::client
