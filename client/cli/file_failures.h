// Errors of single files, printed together by reason.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace motiondb::client {

// The error of one file.
struct FileFailure {
  std::filesystem::path path;
  std::string detail;  // text after the path: ": REASON" or ":LINE: REASON"
};

// Returns the failure with a message, which may begin with the path or the name of the file, as
// messages of file readers do, also after the field of a request: "file_block: walk.bvh: ...".
FileFailure FailureOf(const std::filesystem::path& path, absl::string_view text);

// Prints the failures to standard error, those with the same reason together: messages that differ
// only in path, line, numbers and quoted names.
void PrintFailures(const std::vector<FileFailure>& failures);

}  // namespace motiondb::client
