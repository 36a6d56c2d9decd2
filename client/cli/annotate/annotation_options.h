// Options of the command line for tags and fields of clips.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace motiondb::client {

// Adds an option with one value that may be repeated.
void AddRepeatedOption(CLI::App& command, const char* name, std::vector<std::string>& values,
                       const char* type, const char* description);

// Adds --field NAME[:TYPE]=VALUE, repeated; see ParseFieldOption.
void AddFieldOption(CLI::App& command, std::vector<std::string>& fields, const char* description);

}  // namespace motiondb::client
