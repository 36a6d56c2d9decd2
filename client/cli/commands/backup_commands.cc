// motiondb backup, restore, export-database and import-database.

#include <fmt/format.h>
#include <motiondb/v1/access.pb.h>
#include <motiondb/v1/store.pb.h>

#include <cstdint>
#include <ctime>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "client/call_failure.h"
#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/server_text.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"

namespace motiondb::client {

namespace {

struct WrittenFile {
  std::string file;
  bool force = false;
};

// A written file gets its name when it is complete; a sent file has a size, for the progress.
std::string CheckIsNoStream(const std::string& file) {
  return file == "-" ? "expected the name of a file, got '-'; a standard stream cannot be used"
                     : "";
}

// `existing`: what --force replaces.
void AddWrittenFile(CLI::App& command, WrittenFile& options, const char* existing) {
  command.add_option("FILE", options.file, "Output file; it appears when it is complete")
      ->required()
      ->check(CheckIsNoStream);
  command.add_flag(
      "--force", options.force,
      fmt::format("Replace an existing {}; never the store of a server or another file", existing));
}

// Reports the file. The response is a stream of blocks; this is a summary.
absl::Status Report(const WrittenFile& options, const absl::StatusOr<std::int64_t>& bytes,
                    const GlobalOptions& global) {
  if (!bytes.ok()) return bytes.status();
  if (global.json) {
    PrintText(
        fmt::format("{{\"file\":{},\"total_bytes\":{}}}\n", JsonString(options.file), *bytes));
  } else {
    PrintLine("{}: {:.1f} MB, checksum correct", options.file, static_cast<double>(*bytes) / 1e6);
  }
  return absl::OkStatus();
}

// motiondb backup FILE

struct BackupOptions : WrittenFile {};

void Declare(CLI::App& command, BackupOptions& options) {
  AddWrittenFile(command, options, "backup");
}

absl::Status Run(const BackupOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  ProgressBar bar;
  const auto bytes = client->BackupStore(options.file, options.force,
                                         [&](double share) { bar.Show(share, "backing up"); });
  bar.Clear();
  return Report(options, bytes, global);
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
  command.add_option("FILE", options.file, "Backup file of `motiondb backup`")
      ->required()
      ->check(CheckIsNoStream);
}

// Returns the tokens of `now` that are valid and were not before.
std::vector<v1::Token> NewlyValid(const std::vector<v1::Token>& before,
                                  const std::vector<v1::Token>& now) {
  const std::int64_t now_seconds = std::time(nullptr);
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
         TokensTable(tokens, std::time(nullptr)).ToString();
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

// motiondb export-database DB FILE

namespace {

struct ExportDatabaseOptions : WrittenFile {
  std::string database;
};

void Declare(CLI::App& command, ExportDatabaseOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  AddWrittenFile(command, options, "export or backup");
}

absl::Status Run(const ExportDatabaseOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ExportDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  ProgressBar bar;
  const auto bytes = client->ExportDatabase(request, options.file, options.force,
                                            [&](double share) { bar.Show(share, "exporting"); });
  bar.Clear();
  return Report(options, bytes, global);
}

}  // namespace

void AddExportDatabaseCommand(CommandLine line) {
  AddCommand<ExportDatabaseOptions>(
      line, "export-database",
      "Write a database with its clips, segments, history and models to a file",
      "motiondb export-database walks walks.motiondb", Declare, Run);
}

// motiondb import-database FILE

namespace {

struct ImportDatabaseOptions {
  std::string file;
  std::string as;
};

void Declare(CLI::App& command, ImportDatabaseOptions& options) {
  command.add_option("FILE", options.file, "File of `motiondb export-database`")
      ->required()
      ->check(CheckIsNoStream);
  command.add_option("--as", options.as, "Name of the new database; else the exported name")
      ->type_name("DB");
}

absl::Status Run(const ImportDatabaseOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string id = options.as.empty() ? "" : ShortName(DatabaseName(options.as));
  ProgressBar bar;
  const auto response = client->ImportDatabase(options.file, id, [&](double share) {
    bar.Show(share, share < 1 ? "sending" : "the server checks and stores the database");
  });
  bar.Clear();
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("imported {}, {}", ShortName(response->name()),
              CountText(response->clip_count(), "clip"));
  }
  return absl::OkStatus();
}

}  // namespace

void AddImportDatabaseCommand(CommandLine line) {
  AddCommand<ImportDatabaseOptions>(line, "import-database",
                                    "Add an exported database to the server",
                                    "motiondb import-database walks.motiondb\n"
                                    "motiondb import-database walks.motiondb --as walks-2026",
                                    Declare, Run);
}

}  // namespace motiondb::client
