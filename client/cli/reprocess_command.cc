// motiondb reprocess DB: the stored clips, derived again from their files.
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/operation.pb.h>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/print.h"
#include "client/cli/rebuild_wait.h"
#include "client/cli/resource_name.h"

namespace motiondb::client {
namespace {

struct ReprocessOptions {
  std::string database;
};

void Declare(CLI::App& command, ReprocessOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.footer(
      "Reads the files that were ingested again, by the rules of the server's version, and waits "
      "for\n"
      "the new model. After an upgrade that needs it the server does this by itself. A clip that\n"
      "cannot be derived stays as it is stored; `motiondb describe DB` says why. What is done "
      "stays\n"
      "so where this is interrupted; `motiondb operations` shows and cancels the rest.");
}

absl::Status Run(const ReprocessOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ReprocessDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  auto response = client->ReprocessDatabase(request);
  if (!response.ok()) return response.status();
  auto done = WaitForRebuild(*client, response->operation().name(),
                             "the clips that were derived again stay so");
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
      Declare, Run);
}

}  // namespace motiondb::client
