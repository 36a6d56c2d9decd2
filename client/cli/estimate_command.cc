// motiondb estimate DB FILE: what state is the motion in?
#include <motiondb/v1/query.pb.h>

#include <optional>

#include "client/cli/command.h"
#include "client/cli/estimation_text.h"
#include "client/cli/json_output.h"
#include "client/cli/marker_names.h"
#include "client/cli/print.h"
#include "client/cli/query_options.h"

namespace motiondb::client {
namespace {

struct EstimateOptions {
  QueryOptions query;
  int paths = 1;
  std::optional<int> max_candidates;
  bool fill_every_frame = false;
};

void Declare(CLI::App& command, EstimateOptions& options) {
  AddQueryOptions(command, options.query);
  command.add_option("--paths", options.paths, "How many node paths, best first")
      ->type_name("K")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option("--max-candidates", options.max_candidates,
                  "Candidates kept for each frame and layer; else 16; 0 keeps all (exact)")
      ->type_name("N")
      ->check(NonNegativeNumber());
  command.add_flag("--fill-every-frame", options.fill_every_frame,
                   "Fill in missing markers in every frame; else in the last alone");
}

absl::Status Run(const EstimateOptions& options, const GlobalOptions& global) {
  v1::EstimateRequest request;
  if (absl::Status status = SetQuery(options.query, request); !status.ok()) return status;
  request.set_path_count(options.paths);
  if (options.max_candidates) request.set_max_candidates(*options.max_candidates);
  request.set_fill_every_frame(options.fill_every_frame);
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const auto response = client->Estimate(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    std::vector<std::string> marker_names;
    if (response->filled_frames_size() > 0) {
      auto names = MarkerNames(*client, options.query.database);
      if (!names.ok()) return names.status();
      marker_names = *std::move(names);
    }
    PrintText(EstimationText(*response, marker_names));
  }
  return absl::OkStatus();
}

}  // namespace

void AddEstimateCommand(CommandLine line) {
  AddCommand<EstimateOptions>(line, "estimate", "Say which nodes a motion goes through", Declare,
                              Run);
}

}  // namespace motiondb::client
