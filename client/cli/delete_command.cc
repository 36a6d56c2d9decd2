// motiondb delete DB [CLIP]: a clip, or a whole database.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <unistd.h>

#include <iostream>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/rebuild.h"
#include "client/cli/resource_name.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

struct DeleteOptions {
  std::string database;
  std::string clip;
  bool yes = false;
};

void Declare(CLI::App& command, DeleteOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Delete this clip only; else the whole database");
  command.add_flag("--yes", options.yes,
                   "Do not ask before a whole database is deleted; where standard input is no "
                   "terminal, as in a script, nothing is asked in any case");
}

// On a terminal the database's name must be typed; a script is taken at its word.
absl::Status Confirm(const std::string& name) {
  if (isatty(STDIN_FILENO) != 1) return absl::OkStatus();
  fmt::print(stderr,
             "This deletes all clips and models of {0}. Type {0} to go on: ", text::SafeText(name));
  std::fflush(stderr);
  std::string typed;
  std::getline(std::cin, typed);
  if (typed == name) return absl::OkStatus();
  return absl::CancelledError(fmt::format("{} was not deleted", name));
}

absl::Status DeleteDatabase(const DeleteOptions& options, const GlobalOptions& global) {
  const std::string name = DatabaseName(options.database);
  if (!options.yes) {
    if (const absl::Status status = Confirm(ShortName(name)); !status.ok()) return status;
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteDatabaseRequest request;
  request.set_name(name);
  const auto response = client->DeleteDatabase(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("deleted database {}", ShortName(name));
  }
  return absl::OkStatus();
}

absl::Status DeleteClip(const DeleteOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteClipRequest request;
  request.set_name(ClipName(options.database, options.clip));
  auto response = client->DeleteClip(request);
  if (!response.ok()) return response.status();
  auto done = WaitForRebuild(*client, response->operation().name(), "the clip is deleted");
  if (!done.ok()) return done.status();
  if (global.json) {
    *response->mutable_operation() = *std::move(done);
    PrintJson(*response);
    return absl::OkStatus();
  }
  const auto summary = ModelSummary(*client, *done);
  if (!summary.ok()) return summary.status();
  PrintLine("deleted clip {}; {}", ShortName(request.name()), *summary);
  return absl::OkStatus();
}

absl::Status Run(const DeleteOptions& options, const GlobalOptions& global) {
  return options.clip.empty() ? DeleteDatabase(options, global) : DeleteClip(options, global);
}

}  // namespace

void AddDeleteCommand(CommandLine line) {
  AddCommand<DeleteOptions>(line, "delete",
                            "Delete a clip and wait for the model without it, or a whole database",
                            Declare, Run);
}

}  // namespace motiondb::client
