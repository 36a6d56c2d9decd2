// Reads a configuration file: lines `key = value` in TOML's syntax, without tables.
//
// Not CLI11's own reader (2.1): it tells no line numbers, cuts a quoted value at '#', takes a bare
// word for "true", passes over short lines, and its values beat the environment's.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace motiondb::server {

struct FileSetting {
  int line = 0;  // from 1
  std::string key;
  std::vector<std::string> values;  // one, or an array's
};

// A value is a "string" (with \" \\ \n \t), a 'literal', a bare word or number without spaces,
// or an array of these on one line. '#' begins a comment. Appends a problem, with `name` and line,
// for each line that is not so, and for a key that came before.
std::vector<FileSetting> ParseSettings(const std::string& name, const std::string& text,
                                       std::vector<absl::Status>& problems);

// The file's text. NOT_FOUND, PERMISSION_DENIED; INVALID_ARGUMENT if it is larger than 1 MiB.
absl::StatusOr<std::string> ReadSettingsFile(const std::string& path);

// `values` as the file would have them: bare if one number, true or false, quoted or an array else.
std::string FormatValues(const std::vector<std::string>& values, bool is_array);

}  // namespace motiondb::server
