// The clips that a command line names: files, folders, patterns, standard input, and lists.
#pragma once

#include <motiondb/v1/clip.pb.h>

#include <filesystem>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::client {

// A clip to ingest; empty fields are not set.
struct ClipEntry {
  std::filesystem::path path;
  std::string label;
  std::string subject;
  std::filesystem::path skeleton;
  std::string title;
  std::string description;
  std::vector<std::string> tags;
  std::map<std::string, v1::FieldValue> fields;
};

// Returns the files that arguments name, in the order of the arguments. An argument is:
// - a file, which need not exist;
// - a folder: all motion files (by extension) below it, in order of path. Hidden files and folders
//   are skipped, and folders behind symbolic links, which may form a cycle;
// - a pattern of glob(3), if no such file exists: each match, as if it were an argument;
// - "-": one path per line of `input`, a file or a folder. Blank lines are ignored.
// Errors name the argument: a folder without motion files, a folder that cannot be read, a pattern
// without a match, or an input of more than 64 MiB.
absl::StatusOr<std::vector<std::filesystem::path>> FilesOfArguments(
    const std::vector<std::string>& arguments, std::istream& input);

// Parses a list: tab-separated, with a header line that names the columns. Columns `path` and
// `label`, optionally `subject`, `skeleton`, `title`, `description`, `tags` (separated by commas)
// and `field.NAME` or `field.NAME:TYPE` (ParseField), in any order; others are ignored. An empty
// cell sets nothing. Blank lines and lines that begin with '#' are ignored. Paths are relative to
// the list file. INVALID_ARGUMENT names the file, the line and what was expected.
absl::StatusOr<std::vector<ClipEntry>> ParseClipList(const std::filesystem::path& list_file,
                                                     std::string_view text);

}  // namespace motiondb::client
