// motiondb status, backup, restore and verify.

#include <fmt/format.h>
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/server.pb.h>
#include <motiondb/v1/store.pb.h>
#include <unistd.h>

#include <chrono>
#include <iterator>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "client/call_failure.h"
#include "client/cli/access_text.h"
#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/progress_bar.h"

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

// motiondb backup FILE

namespace {

struct BackupOptions {
  std::string file;
  bool force = false;
};

void Declare(CLI::App& command, BackupOptions& options) {
  command.add_option("FILE", options.file, "Output file; it appears when it is complete")
      ->required();
  command.add_flag("--force", options.force,
                   "Replace an existing backup; never the store of a server or another file");
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
    // The response is a stream of blocks; this is a summary.
    PrintText(
        fmt::format("{{\"file\":{},\"total_bytes\":{}}}\n", JsonString(options.file), *bytes));
  } else {
    PrintLine("{}: {:.1f} MB, checksum correct", options.file, static_cast<double>(*bytes) / 1e6);
  }
  return absl::OkStatus();
}

}  // namespace

void AddBackupCommand(CommandLine line) {
  AddCommand<BackupOptions>(line, "backup",
                            "Write a consistent copy of the whole store while the server works",
                            "motiondb backup monday.motiondb", Declare, Run);
}

// motiondb restore FILE

namespace {

struct RestoreOptions {
  std::string file;
};

void Declare(CLI::App& command, RestoreOptions& options) {
  command.add_option("FILE", options.file, "Backup file of `motiondb backup`")->required();
}

// Returns the tokens of `now` that are valid and were not before.
std::vector<v1::Token> NewlyValid(const std::vector<v1::Token>& before,
                                  const std::vector<v1::Token>& now) {
  const std::int64_t now_seconds = NowMicroseconds() / 1'000'000;
  std::set<std::string> were_valid;
  for (const v1::Token& token : before) {
    if (IsValid(token, now_seconds)) were_valid.insert(token.name());
  }
  std::vector<v1::Token> found;
  for (const v1::Token& token : now) {
    if (IsValid(token, now_seconds) && !were_valid.contains(token.name())) found.push_back(token);
  }
  return found;
}

// The server cannot know which tokens were revoked after the backup was made: its own tokens keep
// their state, and the revocation of a token that it does not have was in the lost store.
std::string NewlyValidText(const std::vector<v1::Token>& tokens) {
  if (tokens.empty()) return "";
  return fmt::format(
             "{} of the backup {} valid now. A token that was revoked after the backup was made is "
             "valid again; revoke it with `motiondb token revoke TOKEN`:\n",
             CountText(std::ssize(tokens), "token"), tokens.size() == 1 ? "is" : "are") +
         TokensTable(tokens, NowMicroseconds() / 1'000'000).ToString();
}

absl::Status Run(const RestoreOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto before = client->AllTokens();
  ProgressBar bar;
  const auto response = client->RestoreStore(options.file, [&](double share) {
    bar.Show(share, share < 1 ? "sending" : "the server checks the backup");
  });
  bar.Clear();
  if (!response.ok()) return response.status();
  const auto now = client->AllTokens();
  const bool can_list = before.ok() && now.ok();
  const std::string tokens = can_list ? NewlyValidText(NewlyValid(*before, *now)) : "";
  if (global.json) {
    PrintJson(*response);
    fmt::print(stderr, "{}", WithStyles(tokens, HasColours(STDERR_FILENO)));
  } else {
    PrintLine("restored {}, {}", CountText(response->database_count(), "database"),
              CountText(response->clip_count(), "clip"));
    PrintText(tokens);
  }
  if (can_list) return absl::OkStatus();
  const absl::Status& failed = before.ok() ? now.status() : before.status();
  return WithMessage(
      failed, fmt::format("the backup is restored, but its valid tokens cannot be listed: {}",
                          std::string(failed.message())));
}

}  // namespace

void AddRestoreCommand(CommandLine line) {
  AddCommand<RestoreOptions>(line, "restore", "Restore a backup into a server without databases",
                             "motiondb restore monday.motiondb", Declare, Run);
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

}  // namespace motiondb::client
