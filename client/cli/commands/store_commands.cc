// motiondb status, verify and migrate.
#include <fmt/format.h>
#include <motiondb/v1/server.pb.h>
#include <motiondb/v1/store.pb.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/cli/server_text.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"

namespace motiondb::client {

namespace {

struct StatusOptions {
  double watch_seconds = 0;  // 0: once
};

void Declare(CLI::App& command, StatusOptions& options) {
  command.add_option("--watch", options.watch_seconds, "Interval of repeated output; else once")
      ->type_name("SECONDS")
      ->check(TimeInSeconds());
}

std::int64_t NowMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

absl::Status ShowOnce(const Client& client, const GlobalOptions& global, bool clears_screen) {
  const auto status = client.GetServerStatus(v1::GetServerStatusRequest());
  if (!status.ok()) return status.status();
  if (global.json) {
    PrintJson(*status);
    return absl::OkStatus();
  }
  const std::string text = StatusText(*status, NowMicroseconds());
  if (clears_screen) ClearOutputScreen();
  PrintText(text);
  FlushOutput();
  return absl::OkStatus();
}

absl::Status Run(const StatusOptions& options, const GlobalOptions& global) {
  if (options.watch_seconds > 0 && !global.output.empty()) {
    return UsageError("--watch excludes --output: it does not end");
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.watch_seconds <= 0) return ShowOnce(*client, global, false);
  // Limited to avoid an overflow.
  const std::chrono::duration<double> pause(std::min(options.watch_seconds, 1e6));
  while (true) {
    const absl::Status shown = ShowOnce(*client, global, true);
    if (!shown.ok()) return shown;
    if (OutputFailed()) return absl::OkStatus();  // main reports it
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace

void AddStatusCommand(CommandLine line) {
  AddCommand<StatusOptions>(line, "status",
                            "Show the state of the server: calls, memory, databases, builds",
                            "motiondb status\nmotiondb status --watch 2", Declare, Run);
}

// motiondb verify

namespace {

struct VerifyOptions {};

void Declare(CLI::App&, VerifyOptions&) {}

// Prints a corrupt item as one line.
void Print(const v1::Corruption& corruption) {
  PrintLine("corrupt: {}{}{}", corruption.resource(), corruption.resource().empty() ? "" : ": ",
            corruption.description());
}

absl::Status Run(const VerifyOptions&, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto on_message = [&](const v1::VerifyStoreResponse& message) {
    if (message.has_progress()) {
      bar.Show(message.progress(), "verifying");
      return absl::OkStatus();
    }
    bar.Clear();
    if (global.json) {
      PrintJson(message);
    } else if (message.has_corruption()) {
      Print(message.corruption());
    }
    return absl::OkStatus();
  };
  const auto summary = client->VerifyStore(on_message);
  bar.Clear();
  if (!summary.ok()) return summary.status();
  if (!global.json) {
    PrintLine("verified {}, {}, {}, {}, {:.1f} MB",
              CountText(summary->database_count(), "database"),
              CountText(summary->clip_count(), "clip"), CountText(summary->model_count(), "model"),
              CountText(summary->skeleton_count(), "skeleton"),
              static_cast<double>(summary->byte_count()) / 1e6);
  }
  if (summary->corruption_count() == 0) return absl::OkStatus();
  return absl::DataLossError(
      fmt::format("{} found", CountText(summary->corruption_count(), "corrupt item")));
}

}  // namespace

void AddVerifyCommand(CommandLine line) {
  AddCommand<VerifyOptions>(line, "verify",
                            "Check everything that is stored; fails if something is corrupt",
                            "motiondb verify", Declare, Run);
}

// motiondb migrate: runs `motiondbd migrate`, which has the engines of stores.

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
