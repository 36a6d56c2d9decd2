// motiondb status: how the server is doing.

#include <fmt/format.h>
#include <motiondb/v1/store.pb.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"

namespace motiondb::client {

namespace {

struct StatusOptions {
  double watch_seconds = 0;  // 0: once
};

void Declare(CLI::App& command, StatusOptions& options) {
  command.add_option("--watch", options.watch_seconds, "Show it again and again, so often")
      ->type_name("SECONDS")
      ->check(TimeInSeconds());
}

std::int64_t NowMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

absl::Status ShowOnce(const Client& client, const GlobalOptions& global, bool on_cleared_screen) {
  const auto status = client.GetServerStatus(v1::GetServerStatusRequest());
  if (!status.ok()) return status.status();
  if (global.json) {
    PrintJson(*status);
    return absl::OkStatus();
  }
  // To the upper left, over what stood there, and nothing below.
  const char* const clear = on_cleared_screen ? "\x1b[H\x1b[J" : "";
  fmt::print("{}", clear);
  PrintText(StatusText(*status, NowMicroseconds()));
  std::fflush(stdout);
  return absl::OkStatus();
}

absl::Status Run(const StatusOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.watch_seconds <= 0) return ShowOnce(*client, global, false);
  // Bounded, so that any number of seconds fits.
  const std::chrono::duration<double> pause(std::min(options.watch_seconds, 1e6));
  while (true) {
    const absl::Status shown = ShowOnce(*client, global, isatty(STDOUT_FILENO) == 1);
    if (!shown.ok()) return shown;
    if (std::ferror(stdout) != 0) return absl::OkStatus();  // main says so
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace

void AddStatusCommand(CommandLine line) {
  AddCommand<StatusOptions>(line, "status",
                            "Show how the server is doing: calls, memory, databases, rebuilds",
                            Declare, Run);
}

// motiondb backup FILE: a copy of the whole store of a running server.

namespace {

struct BackupOptions {
  std::string file;
  bool force = false;
};

void Declare(CLI::App& command, BackupOptions& options) {
  command.add_option("FILE", options.file, "File to write; it is there when it is whole")
      ->required();
  command.add_flag("--force", options.force,
                   "Replace a backup that exists; never a server's store, nor what is no backup");
}

absl::Status Run(const BackupOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto bytes = client->BackupStore(options.file, options.force,
                                         [&](double share) { bar.Show(share, "backing up"); });
  bar.Clear();
  if (!bytes.ok()) return bytes.status();
  if (global.json) {
    // The response is a stream of blocks, so this is its sum.
    fmt::print("{{\"file\":{},\"total_bytes\":{}}}\n", JsonString(options.file), *bytes);
  } else {
    PrintLine("{}: {:.1f} MB, checksum right", options.file, static_cast<double>(*bytes) / 1e6);
  }
  return absl::OkStatus();
}

}  // namespace

void AddBackupCommand(CommandLine line) {
  AddCommand<BackupOptions>(
      line, "backup", "Write a consistent copy of the whole store; the server goes on meanwhile",
      Declare, Run);
}

// motiondb restore FILE: fills a server whose store is empty with a backup.

namespace {

struct RestoreOptions {
  std::string file;
};

void Declare(CLI::App& command, RestoreOptions& options) {
  command.add_option("FILE", options.file, "Backup, as `motiondb backup` wrote it")->required();
}

absl::Status Run(const RestoreOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto response = client->RestoreStore(options.file, [&](double share) {
    bar.Show(share, share < 1 ? "sending" : "the server checks it");
  });
  bar.Clear();
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("restored {}, {}", CountText(response->database_count(), "database"),
              CountText(response->clip_count(), "clip"));
  }
  return absl::OkStatus();
}

}  // namespace

void AddRestoreCommand(CommandLine line) {
  AddCommand<RestoreOptions>(line, "restore",
                             "Fill a server without databases with a backup; refuses a damaged one",
                             Declare, Run);
}

// motiondb verify: reads all that is stored and says what is damaged.

namespace {

struct VerifyOptions {};

void Declare(CLI::App&, VerifyOptions&) {}

// One finding a line, on standard output: it is the answer.
void Print(const v1::Corruption& damage) {
  PrintLine("damaged: {}{}{}", damage.resource(), damage.resource().empty() ? "" : ": ",
            damage.description());
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
    } else if (message.has_damage()) {
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
      fmt::format("{} of damage", CountText(summary->corruption_count(), "finding")));
}

}  // namespace

void AddVerifyCommand(CommandLine line) {
  AddCommand<VerifyOptions>(line, "verify",
                            "Check everything that is stored; fails if something is damaged",
                            Declare, Run);
}

}  // namespace motiondb::client
