// Common parts of the commands of `motiondb`: global options, the connection, and how to add a
// command. `main.cc` parses the command line and runs the chosen command.
#pragma once

#include <motiondb/client.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// Options of every command, before or after its name.
struct GlobalOptions {
  std::string server = ClientOptions().server;
  bool json = false;
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

// Adds a command. `declare` binds `Options` to the command line; `run` executes the command.
template <typename Options>
void AddCommand(CommandLine line, const std::string& name, const std::string& description,
                void (*declare)(CLI::App&, Options&),
                absl::Status (*run)(const Options&, const GlobalOptions&)) {
  CLI::App* command = line.app.add_subcommand(name, description);
  command->fallthrough();
  const auto options = std::make_shared<Options>();
  declare(*command, *options);
  command->callback([options, run, &global = line.global, &chosen = line.chosen] {
    chosen = [options, run, &global] { return run(*options, global); };
  });
}

// Returns whether any option requests TLS.
bool UsesTls(const GlobalOptions& global);

// Connects to the server. The error names the option that may fix it.
absl::StatusOr<Client> Connect(const GlobalOptions& global);

// Validators of numeric options.
CLI::Validator PositiveNumber();
CLI::Validator NonNegativeNumber();
CLI::Validator TimeInSeconds();  // at least 0.001

void AddAuditCommand(CommandLine line);
void AddBackupCommand(CommandLine line);
void AddConvertCommand(CommandLine line);
void AddCreateCommand(CommandLine line);
void AddDeleteCommand(CommandLine line);
void AddDescribeCommand(CommandLine line);
void AddDumpCommand(CommandLine line);
void AddEstimateCommand(CommandLine line);
void AddExportCommand(CommandLine line);
void AddFormatsCommand(CommandLine line);
void AddInspectCommand(CommandLine line);
void AddIngestCommand(CommandLine line);
void AddListCommand(CommandLine line);
void AddMappingCommand(CommandLine line);
void AddMarkerSetCommand(CommandLine line);
void AddObserveCommand(CommandLine line);
void AddOperationsCommand(CommandLine line);
void AddPlanCommand(CommandLine line);
void AddPredictCommand(CommandLine line);
void AddRecognizeCommand(CommandLine line);
void AddReprocessCommand(CommandLine line);
void AddRestoreCommand(CommandLine line);
void AddStatusCommand(CommandLine line);
void AddTokenCommand(CommandLine line);
void AddVerifyCommand(CommandLine line);

// Appends advice to an error about connecting; returns other errors unchanged.
absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global);

// Exit codes of failed commands.

inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kUnreachable = 3;  // of `plan`: the goal is unreachable

// Attaches an exit code to an error.
absl::Status WithExitCode(absl::Status status, int code);

// Returns 0 for OK, the attached exit code, or kFailed if there is none.
int ExitCodeOf(const absl::Status& status);

}  // namespace motiondb::client
