// Starts motiondb-import from other programs. Depends on no other part of motiondb.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::importer {

// Returns the path of motiondb-import: MOTIONDB_IMPORT, beside this program, in
// ../libexec/motiondb or, for a program in the build folder, there. NOT_FOUND lists these places.
absl::StatusOr<std::filesystem::path> FindImportProgram();

struct ImportCall {
  std::vector<std::string> arguments;
  std::vector<std::string> lines = {};  // its standard input
  std::vector<int> files = {};          // open files that it inherits; see PathOfInheritedFile
  std::chrono::seconds timeout = std::chrono::hours(24);
  std::function<bool()> cancelled = {};  // ends the call with CANCELLED within about 20 ms
};

// Path by which the program opens ImportCall::files[index].
std::string PathOfInheritedFile(int index);

// Runs motiondb-import and calls `on_block` for each block of its standard output. Stops at an
// error of `on_block` and returns it. NOT_FOUND if there is no such program; UNAVAILABLE if there
// is no process, INTERNAL if it fails; CANCELLED; DEADLINE_EXCEEDED after the timeout. Thread-safe.
absl::Status RunImportProgram(const ImportCall& call,
                              const std::function<absl::Status(std::string_view)>& on_block);

// Splits blocks into lines.
class LineSplitter {
 public:
  // Calls `on_line` for each line that ends in the block, without line end. Returns the first error
  // of `on_line`; DATA_LOSS for a line of more than 64 MiB.
  absl::Status Add(std::string_view block,
                   const std::function<absl::Status(std::string_view)>& on_line);

 private:
  std::string text_;  // without line end
};

}  // namespace motiondb::importer
