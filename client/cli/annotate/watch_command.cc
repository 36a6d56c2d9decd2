// motiondb watch DB: prints the changes of a database as they happen.
#include <fmt/format.h>
#include <motiondb/v1/database.pb.h>
#include <pthread.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "client/cli/annotate/annotation_text.h"
#include "client/cli/command.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {
namespace {

struct WatchCommandOptions {
  std::string database;
  std::int64_t from_revision = 0;
  bool until_current = false;
};

void Declare(CLI::App& command, WatchCommandOptions& options) {
  command.add_option("DB", options.database, "Database")->required();
  command
      .add_option("--from", options.from_revision,
                  "Print changes after this revision; else first the present state")
      ->type_name("REVISION")
      ->check(NonNegativeNumber());
  command.add_flag("--until-current", options.until_current,
                   "Stop when all stored changes are printed");
  command.footer(
      "A line has revision, what changed, its name, and a short text. Lines with the same revision "
      "are one transaction. If the server stops, waits for it and continues; Ctrl-C ends.");
}

// Blocks Ctrl-C in this thread and in those that it starts from now on.
sigset_t BlockInterrupts() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Calls `on_interrupt` on its own thread when the user presses Ctrl-C.
class InterruptThread {
 public:
  InterruptThread(sigset_t signals, std::function<void()> on_interrupt)
      : thread_([this, signals, on_interrupt = std::move(on_interrupt)] {
          int signal_number = 0;
          sigwait(&signals, &signal_number);
          if (!has_ended_) on_interrupt();
        }) {}
  InterruptThread(const InterruptThread&) = delete;
  InterruptThread& operator=(const InterruptThread&) = delete;
  ~InterruptThread() {
    has_ended_ = true;
    pthread_kill(thread_.native_handle(), SIGINT);
    thread_.join();
  }

 private:
  std::atomic<bool> has_ended_ = false;
  std::thread thread_;
};

void ReportReconnect(const absl::Status& error, std::chrono::milliseconds delay) {
  PrintError(fmt::format("{}; trying again in {:.1f} s", std::string(error.message()),
                         std::chrono::duration<double>(delay).count()));
}

absl::Status Run(const WatchCommandOptions& options, const GlobalOptions& global) {
  const sigset_t signals = BlockInterrupts();  // before the threads of the connection start
  const auto client = Connect(global);
  if (!client.ok()) return client.status();
  v1::WatchDatabaseRequest request;
  request.set_name(DatabaseName(options.database));
  request.set_after_revision(options.from_revision);
  Watch watch = client->WatchDatabase(request, {.on_reconnect = ReportReconnect});
  const InterruptThread interrupt(signals, [&] { watch.Cancel(); });
  v1::WatchDatabaseResponse message;
  bool is_complete = false;
  while (!is_complete && watch.Next(message)) {
    if (global.json) {
      PrintJson(message);
    } else if (const std::string text = ChangeText(message); !text.empty()) {
      PrintLineText(Shortened(text, OutputSize().columns));
    }
    FlushOutput();
    is_complete = OutputFailed() || (options.until_current && message.up_to_date());
  }
  const absl::Status status = watch.Finish();
  return absl::IsCancelled(status) ? absl::OkStatus() : status;
}

}  // namespace

void AddWatchCommand(CommandLine line) {
  AddCommand<WatchCommandOptions>(line, "watch", "Print the changes of a database as they happen",
                                  "motiondb watch walks\n"
                                  "motiondb watch walks --from 120 --until-current --json",
                                  Declare, Run);
}

}  // namespace motiondb::client
