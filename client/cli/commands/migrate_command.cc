// motiondb migrate: runs `motiondbd migrate`, which has the engines of stores.
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"

namespace motiondb::client {
namespace {

constexpr char kServerProgram[] = "motiondbd";

struct MigrateOptions {
  std::string from;
  std::string to;
};

void DeclareMigrate(CLI::App& command, MigrateOptions& options) {
  command.add_option("FROM", options.from, "Store to copy: a file or postgresql://USER@HOST/NAME")
      ->required();
  command.add_option("TO", options.to, "Empty store: a new file or a PostgreSQL database")
      ->required();
}

// Returns the path of motiondbd: beside this program or, of the build folder, in `server`.
absl::StatusOr<std::filesystem::path> FindServerProgram() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  std::vector<fs::path> places = {folder};
  if (folder.filename() == "cli") places.push_back(folder / "../../server");
  for (const fs::path& place : places) {
    if (fs::exists(place / kServerProgram, error)) return place / kServerProgram;
  }
  return absl::NotFoundError(fmt::format("{} is not in {}, beside this program: install it",
                                         kServerProgram, folder.string()));
}

absl::Status RunMigrate(const MigrateOptions& options, const GlobalOptions& global) {
  if (global.json || !global.output.empty()) {
    return UsageError("migrate has no answer for --json or --output");
  }
  const auto program = FindServerProgram();
  if (!program.ok()) return program.status();
  std::vector<std::string> words = {kServerProgram, "migrate", options.from, options.to};
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  FlushOutput();
  execv(program->c_str(), pointers.data());
  return absl::UnavailableError(
      fmt::format("cannot start {}: {}", program->string(), std::strerror(errno)));
}

}  // namespace

void AddMigrateCommand(CommandLine line) {
  AddCommand<MigrateOptions>(
      line, "migrate", "Copy a store between a file and PostgreSQL; continues an interrupted copy",
      "motiondb migrate motion.db postgresql://motiondb@db.example/motiondb\n"
      "motiondb migrate postgresql://motiondb@db.example/motiondb motion.db",
      DeclareMigrate, RunMigrate);
}

}  // namespace motiondb::client
