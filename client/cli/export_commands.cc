// motiondb dump DB DIR and motiondb export DB CLIP.

#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/model.pb.h>

#include <filesystem>

#include "client/cli/command.h"
#include "client/cli/file_formats.h"
#include "client/cli/model_dump.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/progress_bar.h"

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

// motiondb export DB CLIP

namespace {

struct ExportOptions {
  std::string database;
  std::string clip;
  std::string as;
  std::string directory = ".";
  bool force = false;
};

void Declare(CLI::App& command, ExportOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Clip, as in `motiondb list DB`")->required();
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

absl::Status Run(const ExportOptions& options, const GlobalOptions& global) {
  v1::ExportClipRequest request;
  request.set_name(ClipName(options.database, options.clip));
  if (!options.as.empty()) {
    const auto format = WrittenFormat(options.as);
    if (!format.ok()) {
      return UsageError(fmt::format("--as: {}", std::string(format.status().message())));
    }
    request.set_format(*format);
  }
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto header = client->ExportClipToDirectory(request, options.directory, options.force);
  if (!header.ok()) return header.status();
  if (global.json) {
    PrintJson(*header);
    return absl::OkStatus();
  }
  const std::filesystem::path directory(options.directory);
  PrintLine("{}", (directory / header->file_name()).string());
  for (const std::string& note : header->notes()) PrintLine("note:  {}", note);
  if (!header->skeleton_file_name().empty()) {
    PrintLine("{}", (directory / header->skeleton_file_name()).string());
  }
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CommandLine line) {
  AddCommand<ExportOptions>(
      line, "export", "Write a clip's original files, or another format",
      "motiondb export walks 07_01 --out recordings/\nmotiondb export walks 07_01 --as glb",
      Declare, Run);
}

}  // namespace motiondb::client
