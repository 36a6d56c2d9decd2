// motiondb ingest DB [FILE...]: stores motion files and waits for the new model.
#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <optional>

#include "client/cli/annotate/clip_edit.h"
#include "client/cli/clip_files.h"
#include "client/cli/command.h"
#include "client/cli/ingest_batch.h"
#include "client/cli/label_pattern.h"
#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct IngestOptions {
  std::string database;
  std::vector<std::string> files;
  std::string list;
  std::string label;
  std::string label_from;
  std::string subject;
  std::string title;
  std::string description;
  std::vector<std::string> tags;
  std::vector<std::string> fields;
  SourceOptions source;
  bool replace = false;
  bool dry_run = false;
  bool no_wait = false;
  bool quiet = false;
  bool verbose = false;
};

CLI::Validator PatternWithLabel() {
  return CLI::Validator(
      [](const std::string& text) {
        return std::string(LabelPattern::Parse(text).status().message());
      },
      "");
}

void DeclareClips(CLI::App& command, IngestOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.files,
                     "Motion files, folders (all motion files below them), glob patterns, or - for "
                     "paths on standard input, one per line");
  command
      .add_option(
          "--list", options.list,
          "Tab-separated list of clips with a header line: columns path and label, optionally "
          "subject, skeleton, title, description, tags (separated by commas) and field.NAME; paths "
          "are relative to the list")
      ->type_name("FILE.tsv");
  CLI::Option* label =
      command.add_option("--label", options.label, "Label of clips without a label in the list")
          ->type_name("L");
  command
      .add_option("--label-from", options.label_from,
                  "Pattern of the end of the path, with {label} and optionally {subject}")
      ->type_name("PATTERN")
      ->excludes(label)
      ->check(PatternWithLabel());
  command
      .add_option("--subject", options.subject,
                  "Subject of clips without a subject in the list or from --label-from")
      ->type_name("S");
  command
      .add_option("--title", options.title, "Title of clips without a title in the list, one line")
      ->type_name("T");
  command
      .add_option("--description", options.description,
                  "Description of clips without a description in the list")
      ->type_name("TEXT");
  AddRepeatedOption(command, "--tag", options.tags, "TAG", "Tag of all clips; may be repeated");
  AddFieldOption(command, options.fields,
                 "Field of clips without it in the list, NAME=VALUE; may be repeated");
}

void Declare(CLI::App& command, IngestOptions& options) {
  DeclareClips(command, options);
  AddSourceOptions(command, options.source);
  AddForceOption(command, options.source);
  command.add_flag("--replace", options.replace,
                   "Replace the stored clip of the same motion, for example to correct its unit; "
                   "id, label, subject, title, description, tags and fields are kept unless given");
  command.add_flag("--dry-run", options.dry_run,
                   "Check the files on the server and print what would be stored; store nothing");
  command.add_flag("--no-wait", options.no_wait, "Do not wait for the model");
  // Not excludes(): the help would list it at each of the options, also at the global --json.
  command.add_flag("--quiet", options.quiet,
                   "Print only errors, and no progress; not with --verbose or --json");
  command.add_flag("--verbose", options.verbose,
                   "Print each clip and the report of its file, also if there are several");
  command.footer(
      "--label-from '{label}/*' reads the label from the folder; '{subject}_{label}_*' and "
      "'{subject}/{label}/*.bvh' read label and subject. * is any text within a name. A pattern "
      "without a dot in its last name ignores the extension of the file. Waits for the new model. "
      "A file that cannot be ingested does not stop the others; it is reported at the end, and the "
      "exit status is then 1.");
}

// Sets label and subject from the path, if the list contains no label.
absl::Status ReadLabels(const LabelPattern& pattern, const std::string& text, ClipEntry& clip) {
  if (!clip.label.empty()) return absl::OkStatus();
  const auto labels = pattern.Match(clip.path);
  if (!labels) {
    return absl::InvalidArgumentError(
        fmt::format("{}: does not match --label-from '{}'", clip.path.string(), text));
  }
  clip.label = labels->label;
  if (clip.subject.empty()) clip.subject = labels->subject;
  return absl::OkStatus();
}

// Adds title, description, tags and fields of the options to a clip.
absl::Status AddAnnotations(const IngestOptions& options, ClipEntry& clip) {
  if (clip.title.empty()) clip.title = options.title;
  if (clip.description.empty()) clip.description = options.description;
  clip.tags.insert(clip.tags.end(), options.tags.begin(), options.tags.end());
  for (const std::string& text : options.fields) {
    auto field = ParseFieldOption(text);
    if (!field.ok()) return UsageError(std::string(field.status().message()));
    clip.fields.insert(*std::move(field));
  }
  return absl::OkStatus();
}

// Returns the clips of files and list; the options replace empty fields.
absl::StatusOr<std::vector<ClipEntry>> Clips(const IngestOptions& options) {
  std::optional<LabelPattern> pattern;
  if (!options.label_from.empty()) {
    auto parsed = LabelPattern::Parse(options.label_from);
    if (!parsed.ok()) return parsed.status();
    pattern = *std::move(parsed);
  }
  const auto files = FilesOfArguments(options.files, std::cin);
  if (!files.ok()) return files.status();
  std::vector<ClipEntry> clips;
  for (const auto& file : *files) clips.emplace_back().path = file;
  if (!options.list.empty()) {
    const auto text = ReadFileBytes(options.list);
    if (!text.ok()) return text.status();
    auto listed = ParseClipList(options.list, *text);
    if (!listed.ok()) return listed.status();
    std::move(listed->begin(), listed->end(), std::back_inserter(clips));
  }
  if (clips.empty()) return UsageError("nothing to ingest; expected files or --list");
  for (ClipEntry& clip : clips) {
    if (pattern) {
      const absl::Status read = ReadLabels(*pattern, options.label_from, clip);
      if (!read.ok()) return read;
    }
    if (clip.label.empty()) clip.label = options.label;
    if (clip.subject.empty()) clip.subject = options.subject;
    if (clip.skeleton.empty()) clip.skeleton = options.source.skeleton;
    if (absl::Status added = AddAnnotations(options, clip); !added.ok()) return added;
  }
  return clips;
}

// Checked first, so that a wrong database name is one error, not one for each file.
absl::Status CheckDatabase(const Client& client, const std::string& name) {
  v1::GetDatabaseRequest request;
  request.set_name(name);
  return client.GetDatabase(request).status();
}

absl::Status CheckOutputOptions(const IngestOptions& options, const GlobalOptions& global) {
  if (!options.quiet || (!options.verbose && !global.json)) return absl::OkStatus();
  return UsageError(fmt::format("--quiet excludes {}", options.verbose ? "--verbose" : "--json"));
}

IngestOutput OutputOf(const IngestOptions& options, const GlobalOptions& global,
                      std::size_t clip_count) {
  if (options.quiet) return IngestOutput::kNothing;
  if (global.json) return IngestOutput::kJson;
  return options.verbose || clip_count == 1 ? IngestOutput::kEachClip : IngestOutput::kSummary;
}

absl::Status Run(const IngestOptions& options, const GlobalOptions& global) {
  if (absl::Status status = CheckOutputOptions(options, global); !status.ok()) return status;
  const auto clips = Clips(options);
  if (!clips.ok()) return clips.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string database = DatabaseName(options.database);
  if (const absl::Status status = CheckDatabase(*client, database); !status.ok()) return status;
  IngestBatch batch(*client, database,
                    {.source = options.source,
                     .replace = options.replace,
                     .dry_run = options.dry_run,
                     .waits_for_model = !options.no_wait,
                     .output = OutputOf(options, global, clips->size())});
  absl::Status status = batch.Send(*clips);
  if (status.ok()) status = batch.Finish();
  FlushOutput();
  PrintFailures(batch.failures());
  if (!status.ok() || batch.failures().empty()) return status;
  const std::size_t failed = batch.failures().size();
  const char* const verb = options.dry_run ? "would not be" : failed == 1 ? "was not" : "were not";
  return absl::InvalidArgumentError(
      fmt::format("{} of {} {} ingested", failed, CountText(clips->size(), "file"), verb));
}

}  // namespace

void AddIngestCommand(CommandLine line) {
  AddCommand<IngestOptions>(
      line, "ingest", "Store motion files and wait for the new model",
      "motiondb ingest walks 07_01.bvh --label walk --subject 07 --tag outdoor\n"
      "motiondb ingest walks 07_02.bvh --title \"A slow walk\" --field weight_kg=72.5\n"
      "motiondb ingest walks recordings/ --label-from '{subject}_{label}_*'\n"
      "motiondb ingest walks --list clips.tsv --dry-run",
      Declare, Run);
}

}  // namespace motiondb::client
