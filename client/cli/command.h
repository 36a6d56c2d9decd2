// What the commands of `motiondb` have in common: global options, the connection, and the form that
// a command takes. One command, one file; `main.cc` parses, then runs the one that was chosen.
#pragma once

#include <motiondb/client.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace motiondb::client {

// Options that every command takes, before or after its name.
struct GlobalOptions {
  std::string server = ClientOptions().server;
  bool json = false;
  double timeout_seconds = 600;
  std::string token_file;
  bool use_tls = false;  // without any file: the authorities that the system trusts
  TlsOptions tls;
};

// Where a command puts what it will do, while the command line is being read.
struct CommandLine {
  CLI::App& app;
  const GlobalOptions& global;
  std::function<absl::Status()>& chosen;
};

// Adds a command whose `Options` its `declare` binds to the command line and its `run` then uses.
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

// Whether the command line asks for TLS, by any of its options.
bool UsesTls(const GlobalOptions& global);

// Connects to the server that the command line names. An error says which option may mend it.
absl::StatusOr<Client> Connect(const GlobalOptions& global);

// Checks of an option's number, which say what was expected.
CLI::Validator PositiveNumber();
CLI::Validator NonNegativeNumber();
CLI::Validator TimeInSeconds();  // from a millisecond

void AddAuditCommand(CommandLine line);
void AddBackupCommand(CommandLine line);
void AddCreateCommand(CommandLine line);
void AddDeleteCommand(CommandLine line);
void AddDescribeCommand(CommandLine line);
void AddDumpCommand(CommandLine line);
void AddEstimateCommand(CommandLine line);
void AddExportCommand(CommandLine line);
void AddIngestCommand(CommandLine line);
void AddListCommand(CommandLine line);
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

// The same error, and after it what to do; errors that are not about connecting stay as they are.
absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global);

// The program's exit code where a command failed, for those that scripts tell apart.

inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kUnreachable = 3;  // a plan: the goal cannot be reached

// The same error, with which the program is to exit by `code`.
absl::Status WithExitCode(absl::Status status, int code);

// 0 where all is well; kFailed where the error does not say.
int ExitCodeOf(const absl::Status& status);

}  // namespace motiondb::client
