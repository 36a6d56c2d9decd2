// motiondb dump DB DIR: the model as NumPy files.
#include <motiondb/v1/model.pb.h>

#include "client/cli/command.h"
#include "client/cli/count_text.h"
#include "client/cli/json_output.h"
#include "client/cli/model_dump.h"
#include "client/cli/print.h"
#include "client/cli/progress_bar.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct DumpOptions {
  std::string database;
  std::string directory;
  bool force = false;
};

void Declare(CLI::App& command, DumpOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("DIR", options.directory, "Folder to write into, made if absent")->required();
  command.add_flag("--force", options.force,
                   "Replace an earlier dump in a folder that is not empty");
  command.footer(
      "Writes states.npy (frames x dimensions), clip_of_frame.npy, model.json, and for each layer\n"
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
  AddCommand<DumpOptions>(line, "dump", "Write the model as NumPy files", Declare, Run);
}

}  // namespace motiondb::client
