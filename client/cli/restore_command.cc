// motiondb restore FILE: fills a server whose store is empty with a backup.
#include <motiondb/v1/store.pb.h>

#include "client/cli/command.h"
#include "client/cli/count_text.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"

namespace motiondb::client {
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

}  // namespace motiondb::client
