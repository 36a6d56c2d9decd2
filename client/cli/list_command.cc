// motiondb list [DB]: the databases, or the clips of one.
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct ListOptions {
  std::string database;
};

void Declare(CLI::App& command, ListOptions& options) {
  command.add_option("DB", options.database, "List the clips of this database; else all databases");
}

template <typename Item, typename Text>
absl::Status Print(const absl::StatusOr<std::vector<Item>>& items, bool json, const Text& text) {
  if (!items.ok()) return items.status();
  if (json) {
    for (const Item& item : *items) PrintJson(item);
  } else {
    PrintText(text(*items));
  }
  return absl::OkStatus();
}

absl::Status Run(const ListOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.database.empty()) return Print(client->AllDatabases(), global.json, DatabasesText);
  v1::ListClipsRequest request;
  request.set_parent(DatabaseName(options.database));
  request.set_page_size(1000);
  return Print(client->AllClips(request), global.json, ClipsText);
}

}  // namespace

void AddListCommand(CommandLine line) {
  AddCommand<ListOptions>(line, "list", "List the databases, or the clips of one", Declare, Run);
}

}  // namespace motiondb::client
