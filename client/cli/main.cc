// `motiondb`, the command line of a motiondb server: parses, runs one command, reports its error.
#include <fmt/format.h>
#include <grpc/support/log.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "client/cli/command.h"
#include "client/cli/print.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

// What was wrong with the command line, and where help is.
std::string UsageError(const CLI::App* app, const CLI::Error& error) {
  const CLI::App* command = app;
  std::string name = "motiondb";
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  // CLI11 only says that a command is missing where a word is no command.
  const std::vector<std::string> unknown = app->remaining(true);
  const std::string what = unknown.empty() || error.get_name() != "RequiredError"
                               ? error.what()
                               : fmt::format("no such command: {}", unknown.front());
  return fmt::format("motiondb: {}\nTry `{} --help`.\n", text::SafeText(what), name);
}

// gRPC writes what it meets to standard error; what matters of it is in the errors of calls. Who
// asks for it by gRPC's own variable gets it.
void QuietGrpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

void AddGlobalOptions(CLI::App& app, GlobalOptions& global) {
  app.add_option("--server", global.server, "Address of the server")
      ->envname("MOTIONDB_SERVER")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_flag("--json", global.json,
               "Print the server's answer as JSON with the proto's field names; one object a line");
  app.add_option("--timeout", global.timeout_seconds, "How long one call may take")
      ->type_name("SECONDS")
      ->check(TimeInSeconds())
      ->capture_default_str();
  app.add_option("--token-file", global.token_file,
                 "File that holds the token to show; or the token in MOTIONDB_TOKEN")
      ->envname("MOTIONDB_TOKEN_FILE")
      ->type_name("FILE");
  app.add_flag(
         "--tls", global.use_tls,
         "Connect by TLS; the options below do, too. Without --tls-ca the system's authorities "
         "are trusted")
      ->envname("MOTIONDB_TLS");
  app.add_option("--tls-ca", global.tls.ca_file, "Who signs the server's certificate, PEM")
      ->envname("MOTIONDB_TLS_CA")
      ->type_name("FILE");
  app.add_option("--tls-certificate", global.tls.certificate_file,
                 "Certificate to show to a server that asks for one, PEM")
      ->envname("MOTIONDB_TLS_CERTIFICATE")
      ->type_name("FILE");
  app.add_option("--tls-key", global.tls.key_file, "Its key, PEM")
      ->envname("MOTIONDB_TLS_KEY")
      ->type_name("FILE");
  app.add_option("--tls-server-name", global.tls.server_name,
                 "Whom the server's certificate is made out to, if not the host of its address")
      ->envname("MOTIONDB_TLS_SERVER_NAME")
      ->type_name("NAME");
  app.set_version_flag("--version", "motiondb " MOTIONDB_VERSION, "Print the version and exit");
}

int Run(int argc, char** argv) {
  QuietGrpc();
  CLI::App app("motiondb: store, recognize, estimate, predict and plan human motion", "motiondb");
  GlobalOptions global;
  std::function<absl::Status()> chosen;
  app.require_subcommand(1);
  app.failure_message(UsageError);
  // Commands take over the footer that stands when they are added.
  app.footer(
      "Every command also takes --server HOST:PORT, --json, --timeout SECONDS, and what a server\n"
      "with TLS and tokens asks for: see `motiondb --help`.");
  AddGlobalOptions(app, global);
  const CommandLine line{app, global, chosen};
  AddCreateCommand(line);
  AddIngestCommand(line);
  AddListCommand(line);
  AddDescribeCommand(line);
  AddRecognizeCommand(line);
  AddEstimateCommand(line);
  AddPredictCommand(line);
  AddObserveCommand(line);
  AddPlanCommand(line);
  AddDumpCommand(line);
  AddExportCommand(line);
  AddDeleteCommand(line);
  AddReprocessCommand(line);
  AddOperationsCommand(line);
  AddTokenCommand(line);
  AddAuditCommand(line);
  AddStatusCommand(line);
  AddBackupCommand(line);
  AddRestoreCommand(line);
  AddVerifyCommand(line);
  app.footer(
      "DB is the name of a database, with or without \"databases/\". Motion files keep their\n"
      "extensions: .bvh, .amc (its .asf is found beside it), .trc, .c3d. Options may stand before\n"
      "or after the command. `motiondb COMMAND --help` says more about a command.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  absl::Status status = chosen();
  // An answer that did not reach its reader (a full disk) is a failure, too.
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && status.ok()) {
    status = absl::DataLossError("standard output: cannot be written");
  }
  if (status.ok()) return 0;
  // gRPC has no words for some, such as text that is not UTF-8.
  PrintError(status.message().empty() ? absl::StatusCodeToString(status.code())
                                      : std::string(status.message()));
  return ExitCodeOf(status);
}

}  // namespace
}  // namespace motiondb::client

int main(int argc, char** argv) {
  try {
    return motiondb::client::Run(argc, argv);
  } catch (const std::exception& error) {
    motiondb::client::PrintError(error.what());
    return motiondb::client::kFailed;
  }
}
