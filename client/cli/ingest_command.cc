// motiondb ingest DB FILE...: stores motion files and waits for the new model.
#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>

#include <algorithm>

#include "client/cli/command.h"
#include "client/cli/ingest_batch.h"
#include "client/cli/motion_file.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct IngestOptions {
  std::string database;
  std::vector<std::string> files;
  std::string list;
  std::string label;
  std::string subject;
  SourceOptions source;
};

void Declare(CLI::App& command, IngestOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.files, "Motion files");
  command
      .add_option(
          "--list", options.list,
          "Tab-separated list of clips with a header line: columns path and label, optionally "
          "subject and skeleton; paths are relative to the list")
      ->type_name("FILE.tsv");
  command.add_option("--label", options.label, "Label of clips without a label in the list")
      ->type_name("L");
  command
      .add_option("--subject", options.subject, "Subject of clips without a subject in the list")
      ->type_name("S");
  AddSourceOptions(command, options.source);
  command.footer(
      "Waits for the new model. A file that cannot be ingested does not stop the others; it is\n"
      "reported at the end, and the exit status is then 1.");
}

// Returns the clips of files and list; the options replace empty fields.
absl::StatusOr<std::vector<ClipEntry>> Clips(const IngestOptions& options) {
  std::vector<ClipEntry> clips;
  for (const std::string& file : options.files) clips.push_back({file, "", "", {}});
  if (!options.list.empty()) {
    const auto text = ReadFileBytes(options.list);
    if (!text.ok()) return text.status();
    auto listed = ParseClipList(options.list, *text);
    if (!listed.ok()) return listed.status();
    std::move(listed->begin(), listed->end(), std::back_inserter(clips));
  }
  if (clips.empty())
    return absl::InvalidArgumentError("nothing to ingest; expected files or --list");
  for (ClipEntry& clip : clips) {
    if (clip.label.empty()) clip.label = options.label;
    if (clip.subject.empty()) clip.subject = options.subject;
    if (clip.skeleton.empty()) clip.skeleton = options.source.skeleton;
  }
  return clips;
}

// Checked first, so that a wrong database name is one error, not one for each file.
absl::Status CheckDatabase(const Client& client, const std::string& name) {
  v1::GetDatabaseRequest request;
  request.set_name(name);
  return client.GetDatabase(request).status();
}

absl::Status Run(const IngestOptions& options, const GlobalOptions& global) {
  const auto clips = Clips(options);
  if (!clips.ok()) return clips.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string database = DatabaseName(options.database);
  if (const absl::Status status = CheckDatabase(*client, database); !status.ok()) return status;
  IngestBatch batch(*client, database, options.source, global.json);
  absl::Status status = batch.Send(*clips);
  if (status.ok()) status = batch.AwaitModel();
  std::fflush(stdout);
  for (const std::string& failure : batch.failures()) PrintError(failure);
  if (!status.ok() || batch.failures().empty()) return status;
  return absl::InvalidArgumentError(fmt::format("{} of {} {} not ingested", batch.failures().size(),
                                                CountText(clips->size(), "file"),
                                                batch.failures().size() == 1 ? "was" : "were"));
}

}  // namespace

void AddIngestCommand(CommandLine line) {
  AddCommand<IngestOptions>(line, "ingest", "Store motion files and wait for the new model",
                            Declare, Run);
}

}  // namespace motiondb::client
