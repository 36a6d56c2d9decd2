#include "client/cli/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::client {

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
