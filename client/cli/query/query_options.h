// Common options of query commands.
#pragma once

#include <motiondb/v1/query.pb.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <initializer_list>
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
  std::vector<std::string> files;  // files, folders, patterns, or "-" (FilesOfArguments)
  SourceOptions source;
  int layer = 0;
  std::optional<double> floor;
  std::string filter;
  std::int64_t min_revision = 0;
};

// Binds the options to a command that accepts several files, or one.
void AddQueryOptions(CLI::App& command, QueryOptions& options);
void AddQueryOptionsOfOneFile(CLI::App& command, QueryOptions& options);

// As above for a command that can have no files; without the options of nodes, --layer and --floor.
void AddOptionalFileOptions(CLI::App& command, QueryOptions& options);

// Adds --filter and --min-revision, which all queries have.
void AddSelectionOptions(CLI::App& command, std::string& filter, std::int64_t& min_revision);

// Adds --track.
void AddTrackOption(CLI::App& command, std::string& track);

// Adds --method; `method` contains the default.
void AddMethodOption(CLI::App& command, v1::Method& method);

// UsageError if the command line has one of the options `names`, which have no effect with `method`
// but with the other one.
absl::Status RejectOptions(const CLI::App& command, v1::Method method,
                           std::initializer_list<const char*> names);

// A window is called unknown if its probability of unknown motion is greater.
inline constexpr double kDefaultUnknownThreshold = 0.5;

// Adds --unknown-threshold; `threshold` contains the default.
void AddUnknownThresholdOption(CLI::App& command, double& threshold);

// Sets the options in a request. REQUIRES: Request is a complete type.
template <typename Request>
void SetQuery(const QueryOptions& options, Request& request) {
  request.set_database(DatabaseName(options.database));
  if (options.layer > 0) request.set_layer(options.layer);
  if (options.floor) request.set_transition_floor(*options.floor);
  request.set_filter(options.filter);
  request.set_min_revision(options.min_revision);
}

// Returns the marker names of a database in the order of the state vector. NOT_FOUND: no such
// database.
absl::StatusOr<std::vector<std::string>> MarkerNames(const Client& client,
                                                     const std::string& database);

}  // namespace motiondb::client
