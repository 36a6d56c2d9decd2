// motiondb describe DB: the figures of a database and its model.
#include <motiondb/v1/database.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct DescribeOptions {
  std::string database;
};

void Declare(CLI::App& command, DescribeOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
}

absl::Status Run(const DescribeOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::DescribeDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  const auto response = client->DescribeDatabase(request);
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintText(DescriptionText(*response));
  }
  return absl::OkStatus();
}

}  // namespace

void AddDescribeCommand(CommandLine line) {
  AddCommand<DescribeOptions>(line, "describe", "Show a database's frames, clips, layers and nodes",
                              Declare, Run);
}

}  // namespace motiondb::client
