// motiondb export-database and import-database.

#include <fmt/format.h>
#include <motiondb/v1/store.pb.h>

#include <string>

#include "client/cli/command.h"
#include "client/cli/database_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/progress_bar.h"

namespace motiondb::client {

namespace {

struct ExportDatabaseOptions {
  std::string database;
  std::string file;
  bool force = false;
};

void Declare(CLI::App& command, ExportDatabaseOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command.add_option("FILE", options.file, "Output file; it appears when it is complete")
      ->required();
  command.add_flag("--force", options.force,
                   "Replace an existing export or backup; never the store of a server or another "
                   "file");
}

absl::Status Run(const ExportDatabaseOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::ExportDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  ProgressBar bar;
  const auto bytes = client->ExportDatabase(request, options.file, options.force,
                                            [&](double share) { bar.Show(share, "exporting"); });
  bar.Clear();
  if (!bytes.ok()) return bytes.status();
  if (global.json) {
    // The response is a stream of blocks; this is a summary.
    PrintText(
        fmt::format("{{\"file\":{},\"total_bytes\":{}}}\n", JsonString(options.file), *bytes));
  } else {
    PrintLine("{}: {:.1f} MB, checksum correct", options.file, static_cast<double>(*bytes) / 1e6);
  }
  return absl::OkStatus();
}

}  // namespace

void AddExportDatabaseCommand(CommandLine line) {
  AddCommand<ExportDatabaseOptions>(
      line, "export-database",
      "Write a database with its clips, segments, history and models to a file",
      "motiondb export-database walks walks.motiondb", Declare, Run);
}

namespace {

struct ImportDatabaseOptions {
  std::string file;
  std::string as;
};

void Declare(CLI::App& command, ImportDatabaseOptions& options) {
  command.add_option("FILE", options.file, "File of `motiondb export-database`")->required();
  command.add_option("--as", options.as, "Name of the new database; else the exported name")
      ->type_name("DB");
}

absl::Status Run(const ImportDatabaseOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  const std::string id = options.as.empty() ? "" : ShortName(DatabaseName(options.as));
  ProgressBar bar;
  const auto response = client->ImportDatabase(options.file, id, [&](double share) {
    bar.Show(share, share < 1 ? "sending" : "the server checks and stores the database");
  });
  bar.Clear();
  if (!response.ok()) return response.status();
  if (global.json) {
    PrintJson(*response);
  } else {
    PrintLine("imported {}, {}", ShortName(response->name()),
              CountText(response->clip_count(), "clip"));
  }
  return absl::OkStatus();
}

}  // namespace

void AddImportDatabaseCommand(CommandLine line) {
  AddCommand<ImportDatabaseOptions>(line, "import-database",
                                    "Add an exported database to the server",
                                    "motiondb import-database walks.motiondb\n"
                                    "motiondb import-database walks.motiondb --as walks-2026",
                                    Declare, Run);
}

}  // namespace motiondb::client
