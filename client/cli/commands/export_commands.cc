// motiondb dump DB DIR and motiondb export DB [CLIP].

#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/model.pb.h>

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>

#include "client/cli/command.h"
#include "client/cli/model_dump.h"
#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"
#include "client/output_file.h"

namespace motiondb::client {

namespace {

struct DumpOptions {
  std::string database;
  std::string directory;
  bool force = false;
};

void Declare(CLI::App& command, DumpOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("DIR", options.directory, "Output folder, created if necessary")->required();
  command.add_flag("--force", options.force, "Replace an earlier dump if the folder is not empty");
  command.footer(
      "Writes states.npy (frames x dimensions), clip_of_frame.npy, model.json, and for each layer "
      "layers/LL/{node_of_frame,parent,mean,variance,transitions}.npy (transitions: from, to, "
      "count).");
}

absl::Status Run(const DumpOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  absl::Status status = PrepareDumpDirectory(options.directory, options.force);
  if (!status.ok()) return status;
  ProgressBar bar;
  const auto model = DumpModel(
      *client, DatabaseName(options.database), options.directory,
      [&](double fraction, const std::string& doing) { bar.Show(fraction, "reading " + doing); });
  bar.Clear();
  if (!model.ok()) return model.status();
  if (global.json) {
    v1::GetModelResponse response;
    *response.mutable_model() = *model;
    PrintJson(response);
  } else {
    PrintLine("model {}: {}, {}, {}, written to {}", model->version(),
              CountText(model->frame_count(), "frame"),
              CountText(model->dimension_count(), "dimension"),
              CountText(model->nodes_per_layer_size(), "layer"), options.directory);
  }
  return absl::OkStatus();
}

}  // namespace

void AddDumpCommand(CommandLine line) {
  AddCommand<DumpOptions>(line, "dump", "Write the model as NumPy files",
                          "motiondb dump walks model/", Declare, Run);
}

// motiondb export DB [CLIP]

namespace {

struct ExportOptions {
  std::string database;
  std::string clip;
  std::string filter;
  std::string as;
  std::string directory = ".";
  bool force = false;
};

void Declare(CLI::App& command, ExportOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  CLI::Option* const clip =
      command.add_option("CLIP", options.clip, "Clip, as in `motiondb list DB`");
  AddFilterOption(
      command, options.filter,
      "Export all clips that pass this filter, instead of CLIP; clips with the same file "
      "name are in folders with their names")
      ->excludes(clip);
  command
      .add_option(
          "--as", options.as,
          "Write the stored motion in this format, from states and skeleton, as CLIP.FORMAT; "
          "else the original files, byte for byte")
      ->type_name(WrittenFormatNames());
  command.add_option("--out", options.directory, "Output folder, created if necessary")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_flag("--force", options.force, "Replace files with different contents");
}

// Exports a clip and prints its files.
absl::Status ExportOne(const Client& client, const v1::ExportClipRequest& request,
                       const std::filesystem::path& directory, bool force, bool json) {
  const auto header = client.ExportClipToDirectory(request, directory, force);
  if (!header.ok()) return header.status();
  if (json) {
    PrintJson(*header);
    return absl::OkStatus();
  }
  PrintLine("{}", (directory / header->file_name()).string());
  for (const std::string& note : header->notes()) PrintLine("note:  {}", note);
  if (!header->skeleton_file_name().empty()) {
    PrintLine("{}", (directory / header->skeleton_file_name()).string());
  }
  return absl::OkStatus();
}

// Exports the clips that pass the filter. A clip that cannot be exported does not stop the others.
absl::Status ExportFiltered(const Client& client, const ExportOptions& options,
                            v1::ExportClipRequest request, bool json) {
  v1::ListClipsRequest list;
  list.set_parent(DatabaseName(options.database));
  list.set_page_size(1000);
  list.set_filter(options.filter);
  const auto clips = client.AllClips(list);
  if (!clips.ok()) return clips.status();
  if (clips->empty() && !json) PrintLine("exported no clips: none passes the filter");
  std::map<std::string, int> clips_of_file;
  for (const v1::Clip& clip : *clips) ++clips_of_file[clip.file_name()];
  std::size_t failed = 0;
  ProgressBar bar;
  for (std::size_t i = 0; i < clips->size(); ++i) {
    const v1::Clip& clip = (*clips)[i];
    bar.Show(static_cast<double>(i) / static_cast<double>(clips->size()), ShortName(clip.name()));
    std::filesystem::path directory = options.directory;
    const bool is_own_file = request.format() == v1::FILE_FORMAT_UNSPECIFIED;
    if (is_own_file && clips_of_file[clip.file_name()] > 1) {
      const absl::Status named = CheckFileNameFromServer(ShortName(clip.name()));
      if (!named.ok()) return named;
      directory /= ShortName(clip.name());
    }
    request.set_name(clip.name());
    bar.Clear();
    const absl::Status status = ExportOne(client, request, directory, options.force, json);
    if (status.ok()) continue;
    if (absl::IsUnavailable(status)) return status;
    ++failed;
    PrintError(fmt::format("{}: {}", ShortName(clip.name()), std::string(status.message())));
  }
  if (failed == 0) return absl::OkStatus();
  return absl::UnknownError(
      fmt::format("{} of {} not exported", failed, CountText(std::ssize(*clips), "clip")));
}

absl::Status Run(const ExportOptions& options, const GlobalOptions& global) {
  if (options.clip.empty() == options.filter.empty()) {
    return UsageError("expected either CLIP or --filter");
  }
  v1::ExportClipRequest request;
  if (!options.as.empty()) {
    const auto format = WrittenFormat(options.as);
    if (!format.ok()) {
      return UsageError(fmt::format("--as: {}", std::string(format.status().message())));
    }
    request.set_format(*format);
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.clip.empty()) return ExportFiltered(*client, options, request, global.json);
  request.set_name(ClipName(options.database, options.clip));
  return ExportOne(*client, request, options.directory, options.force, global.json);
}

}  // namespace

void AddExportCommand(CommandLine line) {
  AddCommand<ExportOptions>(
      line, "export", "Write the files of a clip, or of all that pass a filter, or another format",
      "motiondb export walks 07_01 --out recordings/\nmotiondb export walks 07_01 --as glb\n"
      "motiondb export walks --filter 'tags:\"selected\"' --out selected/",
      Declare, Run);
}

}  // namespace motiondb::client
