// motiondb segments export.
#include <fmt/format.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/segment.pb.h>

#include <filesystem>
#include <iterator>
#include <map>
#include <set>

#include "client/cli/annotate/segment_files.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/output_file.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

namespace fs = std::filesystem;

struct SegmentsExportOptions {
  std::string database;
  std::string filter;
  std::string format;
  std::string out;
};

void DeclareExport(CLI::App& command, SegmentsExportOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  AddFilterOption(command, options.filter, "Export only segments that pass this filter");
  AddFormatOption(command, options.format, "Format; else by the extension of --out, else tsv");
  command
      .add_option("--out", options.out,
                  "Output file; of --format textgrid a folder, which gets CLIP.TextGrid for each "
                  "clip; else the output")
      ->type_name("FILE|DIR");
  command.footer(
      "TSV and JSON have all that `motiondb segments import` reads. BABEL lacks tracks, "
      "confidences and sources; a TextGrid lacks confidences and sources.");
}

// Returns the clips with segments, in order of name.
absl::StatusOr<std::vector<AnnotatedClip>> AnnotatedClips(
    const Client& client, const std::string& database, const std::vector<Annotation>& annotations) {
  v1::ListClipsRequest request;
  request.set_parent(database);
  request.set_page_size(1000);
  const auto clips = client.AllClips(request);
  if (!clips.ok()) return clips.status();
  const ClipIndex index(*clips);
  std::set<std::string> names;
  for (const Annotation& annotation : annotations) names.insert(annotation.clip);
  std::vector<AnnotatedClip> annotated;
  for (const std::string& name : names) {
    const v1::Clip* const clip = index.Find(name);
    if (clip == nullptr) continue;  // deleted meanwhile
    annotated.push_back({name, index.FileNameOf(*clip), clip->duration_seconds()});
  }
  return annotated;
}

// Writes a file for each clip into a folder.
absl::Status WriteTextGrids(const fs::path& folder, const std::vector<AnnotatedClip>& clips,
                            const std::vector<Annotation>& annotations) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return absl::UnknownError(
        fmt::format("{}: cannot be created: {}", folder.string(), error.message()));
  }
  std::map<std::string, std::vector<Annotation>> of_clip;
  for (const Annotation& annotation : annotations) of_clip[annotation.clip].push_back(annotation);
  for (const AnnotatedClip& clip : clips) {
    const auto bytes = WriteAnnotations(AnnotationFormat::kTextGrid, {clip}, of_clip[clip.clip]);
    if (!bytes.ok()) return bytes.status();
    absl::Status status = CheckFileNameFromServer(clip.clip);
    if (status.ok()) status = WriteFileAtomically(folder / (clip.clip + ".TextGrid"), *bytes);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status WriteOneFile(const std::string& out, AnnotationFormat format,
                          const std::vector<AnnotatedClip>& clips,
                          const std::vector<Annotation>& annotations) {
  const auto bytes = WriteAnnotations(format, clips, annotations);
  if (!bytes.ok()) return bytes.status();
  if (!out.empty()) return WriteFileAtomically(out, *bytes);
  if (format == AnnotationFormat::kTsv) {
    PrintTabSeparated(*bytes);
  } else {
    PrintText(text::EscapedJson(*bytes));
  }
  return absl::OkStatus();
}

absl::Status RunExport(const SegmentsExportOptions& options, const GlobalOptions& global) {
  const auto of_name = AnnotationFormatOf(options.out, "");
  const auto format = NamedFormat(options.format);
  const bool is_folder = format == AnnotationFormat::kTextGrid && of_name != format;
  if (is_folder && options.out.empty()) return UsageError("--format textgrid: expected --out DIR");
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ListSegmentsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_page_size(1000);
  request.set_filter(options.filter);
  const auto segments = client->AllSegments(request);
  if (!segments.ok()) return segments.status();
  const std::vector<Annotation> annotations = AnnotationsOf(*segments);
  const auto clips = AnnotatedClips(*client, request.parent(), annotations);
  if (!clips.ok()) return clips.status();
  const absl::Status written =
      is_folder
          ? WriteTextGrids(options.out, *clips, annotations)
          : WriteOneFile(options.out, format.value_or(of_name.value_or(AnnotationFormat::kTsv)),
                         *clips, annotations);
  if (written.ok() && !options.out.empty() && !global.json) {
    PrintLine("{}: {} of {}", options.out, CountText(std::ssize(annotations), "segment"),
              CountText(std::ssize(*clips), "clip"));
  }
  return written;
}

}  // namespace

void AddSegmentsExportCommand(CommandLine line) {
  AddCommand<SegmentsExportOptions>(line, "export",
                                    "Write segments as TSV, JSON, BABEL or TextGrid",
                                    "motiondb segments export walks --out labels.tsv\n"
                                    "motiondb segments export walks --format textgrid --out grids/",
                                    DeclareExport, RunExport);
}

}  // namespace motiondb::client
