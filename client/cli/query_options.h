// What the queries have in common on the command line: a database, its markers, a motion file, a
// layer, the floor of transitions and, where there is a choice, the method.
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

// Binds them to a command.
void AddQueryOptions(CLI::App& command, QueryOptions& options);

// --method, for the queries that have one; `method` holds the default.
void AddMethodOption(CLI::App& command, v1::Method& method);

// Puts them into a query's request, whose type must be complete, and the file's bytes with them.
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

// Names in the order of a state's markers. NOT_FOUND if there is no such database; errors of the
// connection.
absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database);

}  // namespace motiondb::client
