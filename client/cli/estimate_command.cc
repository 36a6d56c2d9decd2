// motiondb estimate DB FILE: what state is the motion in?
#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <optional>

#include "client/cli/command.h"
#include "client/cli/estimation_text.h"
#include "client/cli/json_output.h"
#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct EstimateOptions {
  std::string database;
  std::string file;
  SourceOptions source;
  int layer = 0;
  int paths = 1;
  std::optional<double> floor;
  std::optional<int> max_candidates;
};

void Declare(CLI::App& command, EstimateOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.file, "Motion file")->required();
  AddSourceOptions(command, options.source);
  command.add_option("--layer", options.layer, "Layer to stop at, from 1; else the bottom layer")
      ->type_name("N")
      ->check(PositiveNumber());
  command.add_option("--paths", options.paths, "How many node paths, best first")
      ->type_name("K")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      .add_option(
          "--floor", options.floor,
          "Probability of a transition that was never seen; else 1e-6; 0 is the strict rule")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0));
  command
      .add_option("--max-candidates", options.max_candidates,
                  "Candidates kept for each frame and layer; else 16; 0 keeps all (exact)")
      ->type_name("N")
      ->check(NonNegativeNumber());
}

absl::Status Run(const EstimateOptions& options, const GlobalOptions& global) {
  auto observation = ObservationFromFile(options.file, options.source);
  if (!observation.ok()) return observation.status();
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::EstimateRequest request;
  request.set_database(DatabaseName(options.database));
  *request.mutable_observation() = *std::move(observation);
  request.set_layer(options.layer);
  request.set_path_count(options.paths);
  if (options.floor) request.set_transition_floor(*options.floor);
  if (options.max_candidates) request.set_max_candidates(*options.max_candidates);
  const auto response = client->Estimate(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    fmt::print("{}", EstimationText(*response));
  }
  return absl::OkStatus();
}

}  // namespace

void AddEstimateCommand(CommandLine line) {
  AddCommand<EstimateOptions>(line, "estimate", "Say which nodes a motion goes through", Declare,
                              Run);
}

}  // namespace motiondb::client
