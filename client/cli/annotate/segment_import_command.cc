// motiondb segments import.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/segment.pb.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "absl/strings/str_join.h"
#include "client/cli/annotate/batch_edit.h"
#include "client/cli/annotate/segment_files.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/usage/usage_error.h"
#include "client/input_file.h"

namespace motiondb::client {
namespace {

// More clips than this are read with one list of all segments.
constexpr std::size_t kMaxClipLists = 20;
constexpr std::size_t kMaxShownNames = 5;

struct SegmentsImportOptions {
  std::string database;
  std::vector<std::string> files;
  std::string format;
  std::string track = "action";
  bool dry_run = false;
  bool no_wait = false;
};

void DeclareImport(CLI::App& command, SegmentsImportOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.files, "Files of annotations")->required();
  AddFormatOption(command, options.format,
                  "Format; else by extension, .tsv, .json (also of BABEL) or .TextGrid");
  command
      .add_option("--track", options.track,
                  "Track of annotations without one; of BABEL, labels that overlap are on T-2 and "
                  "so on")
      ->type_name("T")
      ->capture_default_str();
  command.add_flag("--dry-run", options.dry_run, "Print what would change; change nothing");
  command.add_flag("--no-wait", options.no_wait, "Do not wait until the model has the new labels");
  command.footer(
      "TSV has a header line with clip, start, label and optionally end, track, confidence, source "
      "(seconds; no end: that of the clip); JSON is an array of objects with these names. A clip "
      "is "
      "named by its name or the name of its motion file. A TextGrid has the name of its clip; its "
      "interval tiers are tracks. 1,000 changes are a transaction. A second import changes "
      "nothing.");
}

// Sets `is_babel` if the file has this format.
absl::StatusOr<AnnotationFile> ReadAnnotationFile(const std::string& path,
                                                  const SegmentsImportOptions& options,
                                                  bool& is_babel) {
  const auto bytes = ReadWholeFile(path, kMaxAnnotationBytes);
  if (!bytes.ok()) return bytes.status();
  auto format = NamedFormat(options.format);
  if (!format) format = AnnotationFormatOf(path, *bytes);
  if (!format) {
    return UsageError(fmt::format("{}: expected .tsv, .json or .TextGrid, or --format", path));
  }
  is_babel = is_babel || format == AnnotationFormat::kBabel;
  return ReadAnnotations(*format, path, *bytes, options.track);
}

// Reads the stored segments of the clips that annotations name.
absl::StatusOr<std::vector<v1::Segment>> StoredSegmentsOf(
    const Client& client, const std::string& database, const ClipIndex& clips,
    const std::vector<Annotation>& annotations) {
  std::set<std::string> parents;
  for (const Annotation& annotation : annotations) {
    if (const v1::Clip* const clip = clips.Find(annotation.clip)) parents.insert(clip->name());
  }
  if (parents.size() > kMaxClipLists) parents = {database};
  std::vector<v1::Segment> stored;
  for (const std::string& parent : parents) {
    v1::ListSegmentsRequest request;
    request.set_parent(parent);
    request.set_page_size(1000);
    auto segments = client.AllSegments(request);
    if (!segments.ok()) return segments.status();
    std::ranges::move(*segments, std::back_inserter(stored));
  }
  return stored;
}

std::string NamesText(const std::set<std::string>& names) {
  std::vector<std::string> shown(
      names.begin(), std::next(names.begin(), static_cast<std::ptrdiff_t>(
                                                  std::min(names.size(), kMaxShownNames))));
  if (names.size() > shown.size()) shown.emplace_back("...");
  return absl::StrJoin(shown, ", ");
}

// BABEL describes more sequences than a database has; other files should name only its clips.
absl::Status CheckUnmatched(const SegmentImport& import, const ClipIndex& clips, bool is_babel,
                            const std::string& database) {
  if (import.unmatched.empty() || is_babel) return absl::OkStatus();
  return absl::NotFoundError(fmt::format(
      "database '{}' has no clip, or several, of these names: {}{}", database,
      NamesText(import.unmatched), DidYouMean(*import.unmatched.begin(), clips.Names())));
}

void PrintNote(const std::string& note) {
  fmt::print(stderr, "{}\n", WithStyles("note: " + note, HasColours(STDERR_FILENO)));
}

std::string ImportText(const SegmentImport& import) {
  return fmt::format("{} new, {} changed, {} unchanged", import.created, import.updated,
                     import.unchanged);
}

absl::Status Apply(const Client& client, const SegmentsImportOptions& options,
                   const SegmentImport& import, bool json) {
  if (options.dry_run) {
    if (json) {
      PrintText(
          fmt::format("{{\"created_count\":{},\"updated_count\":{},\"unchanged_count\":{}}}\n",
                      import.created, import.updated, import.unchanged));
    } else {
      PrintLine("would import {}", ImportText(import));
    }
    return absl::OkStatus();
  }
  SentChanges sent;
  absl::Status status = SendChanges(
      client, DatabaseName(options.database), import.changes,
      [&](std::size_t i) { return import.places[i]; }, sent);
  if (json) {
    for (const auto& response : sent.responses) PrintJson(response);
  }
  if (status.ok() && !options.no_wait) {
    status = WaitForModel(client, sent.operation(), "the segments are stored");
  }
  if (!status.ok() || json) return status;
  PrintLine("imported segments: {}{}", ImportText(import),
            sent.stored == 0 ? "" : fmt::format("; revision {}", sent.revision()));
  return absl::OkStatus();
}

absl::Status RunImport(const SegmentsImportOptions& options, const GlobalOptions& global) {
  std::vector<Annotation> annotations;
  bool is_babel = false;
  for (const std::string& path : options.files) {
    auto file = ReadAnnotationFile(path, options, is_babel);
    if (!file.ok()) return file.status();
    for (const std::string& note : file->notes) PrintNote(note);
    std::ranges::move(file->annotations, std::back_inserter(annotations));
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string database = DatabaseName(options.database);
  v1::ListClipsRequest request;
  request.set_parent(database);
  request.set_page_size(1000);
  const auto clips = client->AllClips(request);
  if (!clips.ok()) return clips.status();
  const ClipIndex index(*clips);
  const auto stored = StoredSegmentsOf(*client, database, index, annotations);
  if (!stored.ok()) return stored.status();
  const auto import = PlanSegmentImport(index, *stored, annotations);
  if (!import.ok()) return import.status();
  const absl::Status matched = CheckUnmatched(*import, index, is_babel, ShortName(database));
  if (!matched.ok()) return matched;
  for (const std::string& note : import->notes) PrintNote(note);
  if (!import->unmatched.empty()) {
    PrintNote(fmt::format("not in database '{}', or several: {}: {}", ShortName(database),
                          CountText(std::ssize(import->unmatched), "clip"),
                          NamesText(import->unmatched)));
  }
  return Apply(*client, options, *import, global.json);
}

}  // namespace

void AddSegmentsImportCommand(CommandLine line) {
  AddCommand<SegmentsImportOptions>(
      line, "import", "Store the annotations of files as segments",
      "motiondb segments import walks labels.tsv --dry-run\n"
      "motiondb segments import walks babel_train.json --format babel --track babel\n"
      "motiondb segments import walks annotated/*.TextGrid",
      DeclareImport, RunImport);
}

}  // namespace motiondb::client
