// Common options of query commands.
#pragma once

#include <motiondb/v1/query.pb.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/motion_file.h"
#include "client/cli/resource_name.h"
#include "motiondb/client.h"

namespace motiondb::client {

struct QueryOptions {
  std::string database;
  std::string file;
  SourceOptions source;
  int layer = 0;
  std::optional<double> floor;
};

// Binds the options to a command.
void AddQueryOptions(CLI::App& command, QueryOptions& options);

// Adds --method; `method` contains the default.
void AddMethodOption(CLI::App& command, v1::Method& method);

// A window is called unknown if its probability of unknown motion is greater.
inline constexpr double kDefaultUnknownThreshold = 0.5;

// Adds --unknown-threshold; `threshold` contains the default.
void AddUnknownThresholdOption(CLI::App& command, double& threshold);

// Sets the options and the contents of the file in a request. REQUIRES: Request is a complete type.
template <typename Request>
absl::Status SetQuery(const QueryOptions& options, Request& request) {
  auto observation = ObservationFromFile(options.file, options.source);
  if (!observation.ok()) return observation.status();
  request.set_database(DatabaseName(options.database));
  *request.mutable_observation() = *std::move(observation);
  if (options.layer > 0) request.set_layer(options.layer);
  if (options.floor) request.set_transition_floor(*options.floor);
  return absl::OkStatus();
}

// Returns the marker names of a database in the order of the state vector. NOT_FOUND: no such
// database.
absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database);

}  // namespace motiondb::client
