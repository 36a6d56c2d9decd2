// motiondb backup FILE: a copy of the whole store of a running server.
#include <fmt/format.h>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"

namespace motiondb::client {
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

}  // namespace motiondb::client
