// `motiondb`, the command line of a motiondb server: parses, runs a command, reports its error.
#include <fmt/format.h>
#include <grpc/support/log.h>
#include <motiondb/call_error.h>

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "client/cli/command.h"
#include "client/cli/terminal/print.h"
#include "client/cli/usage/completion.h"
#include "client/cli/usage/help.h"
#include "client/cli/usage/server_names.h"
#include "text/display_text.h"

namespace motiondb::client {
namespace {

// Prints an error and how to get help about the command line.
void PrintUsageError(const std::string& what, const CLI::App& program) {
  PrintError(what);
  fmt::print(stderr, "Try `{} --help`.\n", CommandLineOf(ChosenCommand(program)));
}

// Switches off gRPC's log on standard error, unless gRPC's own variable is set. Errors of calls
// contain the important part.
void QuietGrpc() {
  if (std::getenv("GRPC_VERBOSITY") == nullptr) gpr_set_log_function([](gpr_log_func_args*) {});
}

void AddGlobalOptions(CLI::App& app, GlobalOptions& global) {
  app.add_option("--server", global.server,
                 "Address of the server, or of several servers of one store")
      ->envname("MOTIONDB_SERVER")
      ->type_name("HOST:PORT,...")
      ->capture_default_str();
  app.add_flag("--json", global.json,
               "Print the response as JSON with the field names of the proto, one object per line");
  app.add_flag("--csv", global.csv,
               "Print a table as CSV with its titles: commands that print a table or one for each "
               "file");
  app.add_option("--output", global.output,
                 "Write the answer to this file, which appears when it is complete; else print it")
      ->type_name("FILE");
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

void AddCommands(CommandLine line) {
  AddCreateCommand(line);
  AddIngestCommand(line);
  AddInspectCommand(line);
  AddConvertCommand(line);
  AddFormatsCommand(line);
  AddListCommand(line);
  AddDescribeCommand(line);
  AddSearchCommand(line);
  AddUpdateCommand(line);
  AddSegmentsCommand(line);
  AddHistoryCommand(line);
  AddUndoCommand(line);
  AddWatchCommand(line);
  AddRecognizeCommand(line);
  AddEstimateCommand(line);
  AddPredictCommand(line);
  AddFindCommand(line);
  AddObserveCommand(line);
  AddStreamsCommand(line);
  AddPlanCommand(line);
  AddPictureCommand(line);
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
  AddExportDatabaseCommand(line);
  AddImportDatabaseCommand(line);
  AddVerifyCommand(line);
  AddMigrateCommand(line);
  AddHelpCommand(line);
  AddVersionCommand(line);
}

// Prints the candidates for the last word, each with its description after a tab.
void PrintCandidates(const CLI::App& program, const std::vector<std::string>& words) {
  CLI::App parser;
  GlobalOptions global;
  AddGlobalOptions(parser, global);
  parser.set_help_flag();
  parser.allow_extras();
  try {
    std::vector<std::string> before(words.rbegin() + (words.empty() ? 0 : 1), words.rend());
    parser.parse(std::move(before));
  } catch (const CLI::ParseError&) {
    // An incomplete command line: the options that were read are used.
  }
  for (const Candidate& each : Complete(program, global, words)) {
    fmt::print("{}\t{}\n", text::DisplayText(each.word), text::DisplayText(each.description));
  }
}

// Runs the chosen command, with its output in a file if there is --output.
absl::Status RunChosen(const CLI::App& app, const GlobalOptions& global,
                       const std::function<absl::Status()>& chosen) {
  if (!global.output.empty()) {
    if (absl::Status opened = OpenOutputFile(global.output); !opened.ok()) return opened;
  }
  absl::Status status = chosen();
  // An answer that cannot be written (for example, the disk is full) is a failure.
  const absl::Status ended = EndOutput();
  if (status.ok()) status = ended;
  const std::string reason = ErrorReason(status);
  if (reason == "DATABASE_NOT_FOUND" || reason == "CLIP_NOT_FOUND" ||
      reason == "SEGMENT_NOT_FOUND") {
    const auto client = Connect(global);
    if (client.ok()) return WithNearestName(status, ChosenCommand(app), *client);
  }
  return status;
}

int Run(int argc, char** argv) {
  QuietGrpc();
  CLI::App app("motiondb: store, recognize, estimate, predict and plan human motion", "motiondb");
  GlobalOptions global;
  std::function<absl::Status()> chosen;
  app.require_subcommand(1);
  app.formatter(MakeHelpFormatter());
  AddGlobalOptions(app, global);
  AddCommands({app, global, chosen});
  app.footer(
      "DB is the name of a database, with or without \"databases/\". Motion files keep their "
      "extensions: .bvh, .amc (with its .asf in the same folder), .trc, .c3d, .csv (of a robot, "
      "with its .urdf), .npz, .fbx, .gltf, .glb, .vrm, .dae; `motiondb formats`. Options can be "
      "before or after the command. `motiondb help COMMAND` describes a command. On a terminal, "
      "text has colours unless the variable NO_COLOR is set.");
  AddExamples(app,
              "motiondb create walks\n"
              "motiondb ingest walks recordings/ --label-from '{label}/*'\n"
              "motiondb recognize walks observed.bvh\n"
              "motiondb plan walks --goal 2,1,30deg --out plan.bvh");
  if (argc > 1 && std::string_view(argv[1]) == kCompleteCommand) {
    PrintCandidates(app, {argv + 2, argv + argc});
    return 0;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    PrintText(app.help());
    return 0;
  } catch (const CLI::CallForVersion& version) {
    PrintLineText(version.what());
    return 0;
  } catch (const CLI::ParseError& error) {
    PrintUsageError(ParseErrorText(app, error), app);
    return kWrongUsage;
  }
  const absl::Status status = RunChosen(app, global, chosen);
  if (status.ok()) return 0;
  // Some of gRPC's errors have no message, for example for text that is not UTF-8.
  const std::string message = status.message().empty() ? absl::StatusCodeToString(status.code())
                                                       : std::string(status.message());
  if (ExitCodeOf(status) == kWrongUsage) {
    PrintUsageError(message, app);
  } else {
    PrintError(message);
  }
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
