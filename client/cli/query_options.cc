#include "client/cli/query_options.h"

#include "client/cli/command.h"

namespace motiondb::client {

void AddQueryOptions(CLI::App& command, QueryOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.file, "Motion file")->required();
  AddSourceOptions(command, options.source);
  command.add_option("--layer", options.layer, "Layer of the tree, from 1; else the bottom layer")
      ->type_name("N")
      ->check(PositiveNumber());
  command
      .add_option(
          "--floor", options.floor,
          "Probability of a transition that was never seen; else 1e-6; 0 is the strict rule")
      ->type_name("P")
      ->check(CLI::Range(0.0, 1.0));
}

}  // namespace motiondb::client
