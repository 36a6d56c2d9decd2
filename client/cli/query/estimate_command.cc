// motiondb estimate DB FILE...: the node paths of a motion.
#include <motiondb/v1/query.pb.h>

#include <optional>
#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/query/estimation_prediction_text.h"
#include "client/cli/query/query_files.h"
#include "client/cli/query/query_options.h"

namespace motiondb::client {

namespace {

struct EstimateOptions {
  static constexpr bool kPrintsTable = true;
  QueryOptions query;
  int paths = 1;
  std::optional<int> max_candidates;
  bool fill_every_frame = false;
};

void Declare(CLI::App& command, EstimateOptions& options) {
  AddQueryOptions(command, options.query);
  command.add_option("--paths", options.paths, "Number of node paths, best first")
      ->type_name("K")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option("--max-candidates", options.max_candidates,
                  "Candidates per frame and layer; else 16; 0 keeps all (exact)")
      ->type_name("N")
      ->check(NonNegativeNumber());
  command.add_flag("--fill-every-frame", options.fill_every_frame,
                   "Fill in missing markers in every frame; else only in the last");
}

absl::Status Run(const EstimateOptions& options, const GlobalOptions& global) {
  v1::EstimateRequest request;
  SetQuery(options.query, request);
  request.set_path_count(options.paths);
  if (options.max_candidates) request.set_max_candidates(*options.max_candidates);
  request.set_fill_every_frame(options.fill_every_frame);
  return AskForFiles(options.query, global,
                     [&](const Client& client, QueriedFile& file) -> absl::Status {
                       *request.mutable_observation() = file.TakeObservation();
                       const auto response = client.Estimate(request);
                       if (!response.ok()) return response.status();
                       std::vector<std::string> marker_names;
                       if (!global.json && response->filled_frames_size() > 0) {
                         auto names = MarkerNames(client, options.query.database);
                         if (!names.ok()) return names.status();
                         marker_names = *std::move(names);
                       }
                       file.Print(
                           *response, [&] { return EstimationText(*response, marker_names); },
                           [&] { return EstimationTable(*response); });
                       return absl::OkStatus();
                     });
}

}  // namespace

void AddEstimateCommand(CommandLine line) {
  AddCommand<EstimateOptions>(line, "estimate", "Estimate the node paths of a motion",
                              "motiondb estimate walks observed.bvh\n"
                              "motiondb estimate walks observed.bvh --layer 5 --paths 3",
                              Declare, Run);
}

}  // namespace motiondb::client
