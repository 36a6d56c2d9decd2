// `motiondb`, the command line of a motiondb server: parses, runs a command, reports its error.
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

// Returns the error of a wrong command line, with a hint to --help.
std::string UsageError(const CLI::App* app, const CLI::Error& error) {
  const CLI::App* command = app;
  std::string name = "motiondb";
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  // For an unknown command, CLI11 only reports that a command is missing.
  const std::vector<std::string> unknown = app->remaining(true);
  const std::string what = unknown.empty() || error.get_name() != "RequiredError"
                               ? error.what()
                               : fmt::format("unknown command: {}", unknown.front());
  return fmt::format("motiondb: {}\nTry `{} --help`.\n", text::SafeText(what), name);
}

// Switches off gRPC's log on standard error, unless gRPC's own variable is set. Errors of calls
// contain the important part.
void QuietGrpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

void AddGlobalOptions(CLI::App& app, GlobalOptions& global) {
  app.add_option("--server", global.server, "Address of the server")
      ->envname("MOTIONDB_SERVER")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  app.add_flag("--json", global.json,
               "Print the response as JSON with the field names of the proto, one object per line");
  app.add_option("--timeout", global.timeout_seconds, "Time limit of one call")
      ->type_name("SECONDS")
      ->check(TimeInSeconds())
      ->capture_default_str();
  app.add_option("--token-file", global.token_file,
                 "File with the access token; MOTIONDB_TOKEN can hold the token itself")
      ->envname("MOTIONDB_TOKEN_FILE")
      ->type_name("FILE");
  app.add_flag(
         "--tls", global.use_tls,
         "Connect with TLS; implied by the options below. Without --tls-ca, trust the authorities "
         "of the system")
      ->envname("MOTIONDB_TLS");
  app.add_option("--tls-ca", global.tls.ca_file,
                 "Authority that signed the server's certificate, PEM")
      ->envname("MOTIONDB_TLS_CA")
      ->type_name("FILE");
  app.add_option("--tls-certificate", global.tls.certificate_file,
                 "Client certificate for mutual TLS, PEM")
      ->envname("MOTIONDB_TLS_CERTIFICATE")
      ->type_name("FILE");
  app.add_option("--tls-key", global.tls.key_file, "Key of the client certificate, PEM")
      ->envname("MOTIONDB_TLS_KEY")
      ->type_name("FILE");
  app.add_option("--tls-server-name", global.tls.server_name,
                 "Name in the server's certificate, if it is not the host of the address")
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
  // A command gets the footer that is set when the command is added.
  app.footer(
      "Every command also has the options --server HOST:PORT, --json, --timeout SECONDS, and the\n"
      "options for TLS and tokens: see `motiondb --help`.");
  AddGlobalOptions(app, global);
  const CommandLine line{app, global, chosen};
  AddCreateCommand(line);
  AddIngestCommand(line);
  AddInspectCommand(line);
  AddConvertCommand(line);
  AddFormatsCommand(line);
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
  AddMappingCommand(line);
  AddMarkerSetCommand(line);
  AddOperationsCommand(line);
  AddTokenCommand(line);
  AddAuditCommand(line);
  AddStatusCommand(line);
  AddBackupCommand(line);
  AddRestoreCommand(line);
  AddVerifyCommand(line);
  app.footer(
      "DB is the name of a database, with or without \"databases/\". Motion files keep their\n"
      "extensions: .bvh, .amc (with its .asf in the same folder), .trc, .c3d, .csv (of a robot, "
      "with its .urdf), .npz, .fbx, .gltf, .glb, .vrm, .dae; `motiondb formats`. Options can be "
      "before\n"
      "or after the command. `motiondb COMMAND --help` describes a command.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  absl::Status status = chosen();
  // An answer that cannot be written (for example, the disk is full) is a failure.
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && status.ok()) {
    status = absl::DataLossError("standard output: cannot be written");
  }
  if (status.ok()) return 0;
  // Some of gRPC's errors have no message, for example for text that is not UTF-8.
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
