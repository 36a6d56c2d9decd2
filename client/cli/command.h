// Common parts of the commands of `motiondb`: global options, the connection, and how to add a
// command. `main.cc` parses the command line and runs the chosen command.
#pragma once

#include <motiondb/client.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/terminal/print.h"
#include "client/cli/usage/usage_error.h"

namespace motiondb::client {

// Options of every command, before or after its name.
struct GlobalOptions {
  std::string server = ClientOptions().server;
  bool json = false;
  bool csv = false;    // only of commands that print a table (kPrintsTable)
  std::string output;  // file; empty: standard output
  std::chrono::milliseconds connect_timeout = ClientOptions().connect_timeout;  // not an option
  double timeout_seconds = 600;
  std::string token_file;
  bool use_tls = false;  // without a file: trusts the authorities of the system
  TlsOptions tls;
};

// The parser, its options, and the function of the chosen command.
struct CommandLine {
  CLI::App& app;
  const GlobalOptions& global;
  std::function<absl::Status()>& chosen;
};

// Returns UsageError unless the command prints a table or there is no --csv.
absl::Status CheckFormat(const GlobalOptions& global, const std::string& command,
                         bool prints_table);

// Steps of the functions below.
CLI::App& AddNamedCommand(CommandLine line, const std::string& name,
                          const std::string& description);
void AddExamples(CLI::App& command, const std::string& examples);

// Adds a command. `declare(CLI::App&, Options&)` binds `Options` to the command line;
// `run(const Options&, const GlobalOptions&)` executes the command. `examples` are command lines,
// one per line. A command whose `Options` has the member `kPrintsTable` accepts --csv.
template <typename Options>
void AddCommand(CommandLine line, const std::string& name, const std::string& description,
                const std::string& examples, void (*declare)(CLI::App&, Options&),
                absl::Status (*run)(const Options&, const GlobalOptions&)) {
  CLI::App& command = AddNamedCommand(line, name, description);
  const auto options = std::make_shared<Options>();
  declare(command, *options);
  AddExamples(command, examples);
  command.callback([options, run, &command, &global = line.global, &chosen = line.chosen] {
    chosen = [options, run, &command, &global] {
      constexpr bool kHasTable = requires { Options::kPrintsTable; };
      absl::Status status = CheckFormat(global, CommandLineOf(command), kHasTable);
      return status.ok() ? run(*options, global) : status;
    };
  });
}

// Adds a command that only has commands below it, and returns the line to add them.
CommandLine AddCommandGroup(CommandLine line, const std::string& name,
                            const std::string& description, const std::string& examples);

// Prints messages as JSON, one per line, or as a table (PrintTable).
template <typename Item, typename MakeTable>
void PrintItems(const std::vector<Item>& items, const GlobalOptions& global, MakeTable make_table,
                const char* if_empty) {
  if (global.json) {
    for (const Item& item : items) PrintJson(item);
  } else {
    PrintTable(make_table(items), global.csv, if_empty);
  }
}

// Returns whether any option requests TLS.
bool UsesTls(const GlobalOptions& global);

// Connects to the server. The error names the option that may fix it.
absl::StatusOr<Client> Connect(const GlobalOptions& global);

// Validators of numeric options.
CLI::Validator PositiveNumber();
CLI::Validator NonNegativeNumber();
CLI::Validator TimeInSeconds();  // at least 0.001

// Adds --filter, an expression of docs/filters.md. An empty one is refused: it would select all.
CLI::Option* AddFilterOption(CLI::App& command, std::string& filter, const char* description);

void AddAuditCommand(CommandLine line);
void AddBackupCommand(CommandLine line);
void AddConvertCommand(CommandLine line);
void AddCreateCommand(CommandLine line);
void AddDeleteCommand(CommandLine line);
void AddDescribeCommand(CommandLine line);
void AddDumpCommand(CommandLine line);
void AddEstimateCommand(CommandLine line);
void AddExportCommand(CommandLine line);
void AddExportDatabaseCommand(CommandLine line);
void AddFindCommand(CommandLine line);
void AddFormatsCommand(CommandLine line);
void AddHistoryCommand(CommandLine line);
void AddImportDatabaseCommand(CommandLine line);
void AddInspectCommand(CommandLine line);
void AddIngestCommand(CommandLine line);
void AddListCommand(CommandLine line);
void AddMappingCommand(CommandLine line);
void AddMarkerSetCommand(CommandLine line);
void AddMigrateCommand(CommandLine line);
void AddObserveCommand(CommandLine line);
void AddOperationsCommand(CommandLine line);
void AddPictureCommand(CommandLine line);
void AddPlanCommand(CommandLine line);
void AddPredictCommand(CommandLine line);
void AddRecognizeCommand(CommandLine line);
void AddReprocessCommand(CommandLine line);
void AddRestoreCommand(CommandLine line);
void AddSearchCommand(CommandLine line);
void AddSegmentsCommand(CommandLine line);
void AddStatusCommand(CommandLine line);
void AddStreamsCommand(CommandLine line);
void AddTokenCommand(CommandLine line);
void AddUndoCommand(CommandLine line);
void AddUpdateCommand(CommandLine line);
void AddVerifyCommand(CommandLine line);
void AddWatchCommand(CommandLine line);

// Appends advice to an error about connecting; returns other errors unchanged.
absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global);

}  // namespace motiondb::client
