#include "client/cli/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::client {
namespace {

CLI::Validator NumberThat(const char* expected, bool (*fits)(double)) {
  return CLI::Validator(
      [expected, fits](const std::string& text) {
        double number = 0;
        const bool ok = CLI::detail::lexical_cast(text, number) && std::isfinite(number);
        return ok && fits(number) ? "" : fmt::format("expected {}, got {}", expected, text);
      },
      "");
}

}  // namespace

CLI::Validator PositiveNumber() {
  return NumberThat("a number above 0", [](double number) { return number > 0; });
}

CLI::Validator NonNegativeNumber() {
  return NumberThat("0 or a number above it", [](double number) { return number >= 0; });
}

absl::StatusOr<Client> Connect(const GlobalOptions& global) {
  ClientOptions options;
  options.server = global.server;
  // Bounded, so that any number of seconds fits.
  const double timeout_seconds = std::min(global.timeout_seconds, 1e9);
  options.call_timeout = std::chrono::milliseconds(std::llround(timeout_seconds * 1000));
  auto client = Client::Connect(options);
  if (!client.ok() && absl::IsUnavailable(client.status())) {
    return absl::UnavailableError(
        fmt::format("{} with --server or MOTIONDB_SERVER", std::string(client.status().message())));
  }
  return client;
}

}  // namespace motiondb::client
