#include "client/cli/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>

#include "client/call_failure.h"
#include "client/input_file.h"

namespace motiondb::client {

namespace {

constexpr size_t kMaxTokenFileBytes = size_t{64} << 10;

CLI::Validator NumberThat(const char* expected, bool (*fits)(double)) {
  return CLI::Validator(
      [expected, fits](const std::string& text) {
        double number = 0;
        const bool ok = CLI::detail::lexical_cast(text, number) && std::isfinite(number);
        return ok && fits(number) ? "" : fmt::format("expected {}, got {}", expected, text);
      },
      "");
}

// There is no flag for the token, because every user of the machine can read command lines.
absl::StatusOr<std::string> ReadToken(const GlobalOptions& global) {
  if (global.token_file.empty()) {
    const char* const token = std::getenv("MOTIONDB_TOKEN");
    return std::string(token == nullptr ? "" : token);
  }
  const auto bytes = ReadWholeFile(global.token_file, kMaxTokenFileBytes);
  if (!bytes.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("--token-file: {}", std::string(bytes.status().message())));
  }
  std::string token;
  if (std::istringstream(*bytes) >> token) return token;
  return absl::InvalidArgumentError(
      fmt::format("--token-file: {}: expected a token, but the file is empty", global.token_file));
}

}  // namespace

bool UsesTls(const GlobalOptions& global) {
  const TlsOptions& tls = global.tls;
  return global.use_tls || !tls.ca_file.empty() || !tls.certificate_file.empty() ||
         !tls.key_file.empty() || !tls.server_name.empty();
}

CLI::Validator PositiveNumber() {
  return NumberThat("a number greater than 0", [](double number) { return number > 0; });
}

CLI::Validator NonNegativeNumber() {
  return NumberThat("a number of at least 0", [](double number) { return number >= 0; });
}

CLI::Validator TimeInSeconds() {
  return NumberThat("a number of at least 0.001 seconds",
                    [](double number) { return number >= 0.001; });
}

CLI::Option* AddFilterOption(CLI::App& command, std::string& filter, const char* description) {
  return command.add_option("--filter", filter, description)
      ->type_name("F")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return text.find_first_not_of(' ') == std::string::npos
                       ? "expected a filter, as in 'label = \"walk\"', got nothing"
                       : "";
          },
          ""));
}

absl::Status CheckFormat(const GlobalOptions& global, const std::string& command,
                         bool prints_table) {
  if (global.csv && global.json) return UsageError("--csv excludes --json");
  if (!global.csv || prints_table) return absl::OkStatus();
  return UsageError(fmt::format("--csv: `{}` prints no table", command));
}

CLI::App& AddNamedCommand(CommandLine line, const std::string& name,
                          const std::string& description) {
  CLI::App* const command = line.app.add_subcommand(name, description);
  command->fallthrough();
  command->footer("");  // not that of the group
  return *command;
}

void AddExamples(CLI::App& command, const std::string& examples) {
  std::string text = "Examples:\n  " + examples;
  for (std::size_t end = text.find('\n', text.find('\n') + 1); end != std::string::npos;
       end = text.find('\n', end + 1)) {
    text.insert(end + 1, "  ");
  }
  const std::string notes = command.get_footer();
  command.footer(text + (notes.empty() ? "" : "\n\n" + notes));
}

CommandLine AddCommandGroup(CommandLine line, const std::string& name,
                            const std::string& description, const std::string& examples) {
  CLI::App& group = AddNamedCommand(line, name, description);
  group.require_subcommand(1);
  AddExamples(group, examples);
  return {group, line.global, line.chosen};
}

absl::StatusOr<Client> Connect(const GlobalOptions& global) {
  ClientOptions options;
  options.server = global.server;
  options.connect_timeout = global.connect_timeout;
  const auto token = ReadToken(global);
  if (!token.ok()) return token.status();
  options.token = *token;
  if (UsesTls(global)) options.tls = global.tls;
  // Limited to avoid an overflow.
  const double timeout_seconds = std::min(global.timeout_seconds, 1e9);
  options.call_timeout = std::chrono::milliseconds(std::llround(timeout_seconds * 1000));
  auto client = Client::Connect(options);
  if (!client.ok()) return WithConnectAdvice(client.status(), global);
  return client;
}

namespace {

std::string ClosedAdvice(const GlobalOptions& global) {
  if (!UsesTls(global)) return "connect with --tls, or --tls-ca FILE";
  return global.tls.certificate_file.empty()
             ? "set one with --tls-certificate FILE and --tls-key FILE"
             : "set another with --tls-certificate FILE and --tls-key FILE";
}

std::string NotGrpcAdvice(const GlobalOptions& global) {
  const std::string address = "set the server's address with --server";
  return UsesTls(global) ? address : address + ", or connect with --tls or --tls-ca FILE";
}

std::string Advice(ConnectFailure failure, const GlobalOptions& global) {
  switch (failure) {
    case ConnectFailure::kNotListening:
      return "or set the address of a running server with --server or MOTIONDB_SERVER";
    case ConnectFailure::kClosed:
      return ClosedAdvice(global);
    case ConnectFailure::kNotGrpc:
      return NotGrpcAdvice(global);
    case ConnectFailure::kNotTls:
      return "omit --tls and the options and variables that begin with --tls- and MOTIONDB_TLS";
    case ConnectFailure::kUntrusted:
      return "set the certificate of its authority with --tls-ca";
    case ConnectFailure::kNameMismatch:
      return "set the name in the certificate with --tls-server-name, or use it with --server";
    case ConnectFailure::kUnusableTlsFiles:
      return "check --tls-ca, --tls-certificate and --tls-key";
    case ConnectFailure::kUnknownHost:
    case ConnectFailure::kNoResponse:
    case ConnectFailure::kOther:
      break;
  }
  return "set the server's address with --server or MOTIONDB_SERVER";
}

}  // namespace

absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global) {
  const auto failure = AttachedConnectFailure(status);
  if (!failure) return status;
  return WithMessage(
      status, fmt::format("{}; {}", std::string(status.message()), Advice(*failure, global)));
}

}  // namespace motiondb::client
