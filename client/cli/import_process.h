// Runs motiondb-import, the program that reads files in a sandbox.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// Returns the path of motiondb-import: MOTIONDB_IMPORT, beside this program, in
// ../libexec/motiondb or, for a program in the build folder, there. NOT_FOUND lists these places.
absl::StatusOr<std::filesystem::path> FindImportProgram();

// Runs `motiondb-import` with the arguments, writes the lines to its standard input, and calls
// `on_line` for each line of its standard output, without line end. Stops at an error of `on_line`
// and returns it. UNAVAILABLE if the program cannot be started or fails; DATA_LOSS for a line of
// more than 64 MiB.
absl::Status RunImportProgram(const std::vector<std::string>& arguments,
                              const std::vector<std::string>& lines,
                              const std::function<absl::Status(std::string_view)>& on_line);

}  // namespace motiondb::client
