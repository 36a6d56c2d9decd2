// motiondb export DB CLIP: the original files, byte for byte.
#include <motiondb/v1/clip.pb.h>

#include <filesystem>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct ExportOptions {
  std::string database;
  std::string clip;
  std::string directory = ".";
  bool force = false;
};

void Declare(CLI::App& command, ExportOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("CLIP", options.clip, "Clip, as `motiondb list DB` names it")->required();
  command.add_option("--out", options.directory, "Folder to write into, made if absent")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_flag("--force", options.force, "Replace files of other contents");
}

absl::Status Run(const ExportOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ExportClipRequest request;
  request.set_name(ClipName(options.database, options.clip));
  const auto header = client->ExportClipToDirectory(request, options.directory, options.force);
  if (!header.ok()) return header.status();
  if (global.json) {
    PrintJson(*header);
    return absl::OkStatus();
  }
  const std::filesystem::path directory(options.directory);
  PrintLine("{}", (directory / header->clip().file_name()).string());
  if (!header->skeleton_file_name().empty()) {
    PrintLine("{}", (directory / header->skeleton_file_name()).string());
  }
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CommandLine line) {
  AddCommand<ExportOptions>(line, "export", "Write a clip's original files, byte for byte", Declare,
                            Run);
}

}  // namespace motiondb::client
