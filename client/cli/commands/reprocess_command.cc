// motiondb reprocess DB: derives the stored clips again from their files.
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct ReprocessOptions {
  std::string database;
};

void Declare(CLI::App& command, ReprocessOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.footer(
      "Reads the ingested files again with the current version of the server, and waits for the "
      "new model. After an upgrade the server does this itself if necessary. A clip that cannot be "
      "derived stays unchanged; `motiondb describe DB` shows why. If this command is interrupted, "
      "the server continues; `motiondb operations` shows and cancels the operation.");
}

absl::Status Run(const ReprocessOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ReprocessDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  auto response = client->ReprocessDatabase(request);
  if (!response.ok()) return response.status();
  auto done = WaitForRebuild(*client, response->operation().name(),
                             "clips that were derived again keep their new states");
  if (!done.ok()) return done.status();
  if (global.json) {
    *response->mutable_operation() = *std::move(done);
    PrintJson(*response);
    return absl::OkStatus();
  }
  const auto summary = ModelSummary(*client, *done);
  if (!summary.ok()) return summary.status();
  v1::GetDatabaseRequest get;
  get.set_name(request.name());
  get.set_view(v1::DATABASE_VIEW_FULL);
  const auto database = client->GetDatabase(get);
  if (!database.ok()) return database.status();
  PrintLine("reprocessed {}: {}; {}", ShortName(request.name()), done->stage(), *summary);
  PrintText(UnderivedText(database->database().statistics()));
  return absl::OkStatus();
}

}  // namespace

void AddReprocessCommand(CommandLine line) {
  AddCommand<ReprocessOptions>(
      line, "reprocess", "Derive the stored clips again from their files, and rebuild the model",
      "motiondb reprocess walks", Declare, Run);
}

}  // namespace motiondb::client
