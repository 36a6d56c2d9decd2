// motiondb delete DB [CLIP]: deletes a database, a clip, or the clips that pass a filter.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>
#include <unistd.h>

#include <iostream>

#include "client/call_failure.h"
#include "client/cli/command.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

struct DeleteOptions {
  std::string database;
  std::string clip;
  std::string filter;
  bool dry_run = false;
  bool yes = false;
};

void Declare(CLI::App& command, DeleteOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  CLI::Option* const clip =
      command.add_option("CLIP", options.clip, "Clip to delete; else the whole database");
  CLI::Option* const filter = AddFilterOption(
      command, options.filter, "Delete all clips that pass this filter, instead of CLIP");
  filter->excludes(clip);
  command
      .add_flag("--dry-run", options.dry_run,
                "Print how many clips pass the filter; delete nothing")
      ->needs(filter);
  command.add_flag(
      "--yes", options.yes,
      "Do not ask before a whole database or the clips that pass a filter are deleted. "
      "If standard input is not a terminal, as in a script, it never asks");
}

// On a terminal, asks the user to type the name of the database. Scripts are not asked.
absl::Status Confirm(const std::string& what, const std::string& name) {
  if (isatty(STDIN_FILENO) != 1) return absl::OkStatus();
  fmt::print(stderr, "This deletes {} of {}. Type {} to continue: ", what, text::SafeText(name),
             text::SafeText(name));
  std::fflush(stderr);
  std::string typed;
  std::getline(std::cin, typed);
  if (typed == name) return absl::OkStatus();
  return absl::CancelledError(fmt::format("{} was not deleted", name));
}

absl::Status DeleteDatabase(const DeleteOptions& options, const GlobalOptions& global) {
  const std::string name = DatabaseName(options.database);
  if (!options.yes) {
    const absl::Status status = Confirm("all clips and models", ShortName(name));
    if (!status.ok()) return status;
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

// Waits for the model without the deleted clips and reports it.
absl::Status FinishDelete(const Client& client, v1::DeleteClipResponse response,
                          const std::string& deleted, bool json) {
  auto done = WaitForRebuild(client, response.operation().name(), deleted + " deleted");
  if (!done.ok()) return done.status();
  if (json) {
    *response.mutable_operation() = *std::move(done);
    PrintJson(response);
    return absl::OkStatus();
  }
  const auto summary = ModelSummary(client, *done);
  if (!summary.ok()) return summary.status();
  PrintLine("deleted {}; {}", deleted, *summary);
  return absl::OkStatus();
}

absl::Status DeleteClip(const DeleteOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DeleteClipRequest request;
  request.set_name(ClipName(options.database, options.clip));
  const auto response = client->DeleteClip(request);
  if (!response.ok()) return response.status();
  return FinishDelete(*client, *response, "clip " + ShortName(request.name()), global.json);
}

// Deletes clips one after the other. A clip that another user has deleted meanwhile is skipped.
absl::Status DeleteClips(const Client& client, const std::vector<v1::Clip>& clips, bool json) {
  ProgressBar bar;
  std::int64_t deleted = 0;
  v1::DeleteClipResponse last;
  for (const v1::Clip& clip : clips) {
    bar.Show(static_cast<double>(deleted) / static_cast<double>(clips.size()),
             fmt::format("{} of {}  {}", deleted, clips.size(), ShortName(clip.name())));
    v1::DeleteClipRequest request;
    request.set_name(clip.name());
    auto response = client.DeleteClip(request);
    if (absl::IsNotFound(response.status())) continue;
    if (!response.ok()) {
      bar.Clear();
      return WithMessage(response.status(),
                         fmt::format("{}; {} deleted", std::string(response.status().message()),
                                     CountText(deleted, "clip")));
    }
    ++deleted;
    last = *std::move(response);  // the last rebuild removes all of them
  }
  bar.Clear();
  if (deleted > 0) return FinishDelete(client, last, CountText(deleted, "clip"), json);
  if (!json) PrintLine("deleted no clips: none passes the filter");
  return absl::OkStatus();
}

absl::Status DeleteFiltered(const DeleteOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_page_size(1000);
  request.set_filter(options.filter);
  const auto clips = client->AllClips(request);
  if (!clips.ok()) return clips.status();
  const std::string count = CountText(std::ssize(*clips), "clip");
  if (options.dry_run) {
    if (global.json) {
      PrintText(fmt::format("{{\"clip_count\":{}}}\n", clips->size()));
    } else {
      PrintLine("would delete {}", count);
    }
    return absl::OkStatus();
  }
  if (!options.yes && !clips->empty()) {
    const absl::Status status = Confirm(count, ShortName(request.parent()));
    if (!status.ok()) return status;
  }
  return DeleteClips(*client, *clips, global.json);
}

absl::Status Run(const DeleteOptions& options, const GlobalOptions& global) {
  if (!options.filter.empty()) return DeleteFiltered(options, global);
  return options.clip.empty() ? DeleteDatabase(options, global) : DeleteClip(options, global);
}

}  // namespace

void AddDeleteCommand(CommandLine line) {
  AddCommand<DeleteOptions>(line, "delete",
                            "Delete a clip, all clips that pass a filter, or a whole database",
                            "motiondb delete walks 07_01\n"
                            "motiondb delete walks --filter 'label = \"noise\"' --dry-run\n"
                            "motiondb delete walks --yes",
                            Declare, Run);
}

}  // namespace motiondb::client
