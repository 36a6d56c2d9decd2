// motiondb status: how the server is doing.
#include <fmt/format.h>
#include <motiondb/v1/store.pb.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "client/cli/command.h"
#include "client/cli/json_output.h"
#include "client/cli/print.h"
#include "client/cli/status_text.h"

namespace motiondb::client {
namespace {

struct StatusOptions {
  double watch_seconds = 0;  // 0: once
};

void Declare(CLI::App& command, StatusOptions& options) {
  command.add_option("--watch", options.watch_seconds, "Show it again and again, so often")
      ->type_name("SECONDS")
      ->check(TimeInSeconds());
}

std::int64_t NowMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

absl::Status ShowOnce(const Client& client, const GlobalOptions& global, bool on_cleared_screen) {
  const auto status = client.GetServerStatus(v1::GetServerStatusRequest());
  if (!status.ok()) return status.status();
  if (global.json) {
    PrintJson(*status);
    return absl::OkStatus();
  }
  // To the upper left, over what stood there, and nothing below.
  const char* const clear = on_cleared_screen ? "\x1b[H\x1b[J" : "";
  fmt::print("{}", clear);
  PrintText(StatusText(*status, NowMicroseconds()));
  std::fflush(stdout);
  return absl::OkStatus();
}

absl::Status Run(const StatusOptions& options, const GlobalOptions& global) {
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  if (options.watch_seconds <= 0) return ShowOnce(*client, global, false);
  // Bounded, so that any number of seconds fits.
  const std::chrono::duration<double> pause(std::min(options.watch_seconds, 1e6));
  while (true) {
    const absl::Status shown = ShowOnce(*client, global, isatty(STDOUT_FILENO) == 1);
    if (!shown.ok()) return shown;
    if (std::ferror(stdout) != 0) return absl::OkStatus();  // main says so
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace

void AddStatusCommand(CommandLine line) {
  AddCommand<StatusOptions>(line, "status",
                            "Show how the server is doing: calls, memory, databases, rebuilds",
                            Declare, Run);
}

}  // namespace motiondb::client
