// motiondbd: opens the store, serves until SIGTERM, SIGINT or SIGHUP, and drains.
#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/grpc.h>
#include <grpc/support/log.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/motion/error.h"
#include "server/engine/work/memory_reserve.h"
#include "server/listen/listen_on.h"
#include "server/listen/listener.h"
#include "server/migrate_command.h"
#include "server/observability/health_server.h"
#include "server/observability/log.h"
#include "server/rpc/call_identity.h"
#include "server/server.h"
#include "server/settings/process_limits.h"
#include "server/settings/settings_reader.h"
#include "storage/postgres/postgres_motion_store.h"
#include "storage/sqlite/schema.h"
#include "storage/sqlite/sqlite_motion_store.h"
#include "storage/sqlite/store_file.h"
#include "storage/store_url.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

// Sends the state to the service manager by the protocol of sd_notify(3): a datagram to the socket
// NOTIFY_SOCKET. Implemented here to avoid a dependency on libsystemd. `state`: lines of
// NAME=VALUE, such as "READY=1". Does nothing if NOTIFY_SOCKET is not set.
void NotifyServiceManager(const std::string& state) {
  const char* const name = std::getenv("NOTIFY_SOCKET");
  if (name == nullptr || name[0] == '\0') return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t length = std::strlen(name);
  if (length >= sizeof(address.sun_path)) {
    spdlog::warn("NOTIFY_SOCKET: the name of the socket is too long: {}", name);
    return;
  }
  std::memcpy(address.sun_path, name, length);
  if (name[0] == '@') address.sun_path[0] = '\0';  // abstract socket address
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);

  const int socket_fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0 || sendto(socket_fd, state.data(), state.size(), MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address), size) < 0) {
    spdlog::warn("NOTIFY_SOCKET {}: {}", name, std::strerror(errno));
  }
  if (socket_fd >= 0) close(socket_fd);
}

void LogGrpc() {
  // The server returns and logs gRPC's errors itself, as a status.
  gpr_set_log_function([](gpr_log_func_args* line) { spdlog::debug("grpc: {}", line->message); });
  // Clients must not be able to write log lines: invalid UTF-8 is reported as a field violation.
  google::protobuf::SetLogHandler(
      [](google::protobuf::LogLevel, const char*, int, const std::string& message) {
        spdlog::debug("protobuf: {}", message);
      });
}

// Only the owner can read new files, and a closed pipe on standard output is no error. Large arrays
// of calls return to the system when they are freed; by default glibc keeps larger and larger ones.
// Arrays of a usual ingest are reused: returning them costs a tenth of its time.
void SetUpProcess() {
  mallopt(M_MMAP_THRESHOLD, 2 << 20);
  mallopt(M_TRIM_THRESHOLD, 4 << 20);
  RaiseDescriptorLimit();
  LimitMallocArenas();
  umask(0077);
  std::signal(SIGPIPE, SIG_IGN);
}

// Adds the signals that drain the server. SIGHUP is one, so that closing the terminal drains it,
// unless nohup ignores SIGHUP.
void AddDrainSignals(boost::asio::signal_set& signals) {
  signals.add(SIGTERM);
  signals.add(SIGINT);
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) signals.add(SIGHUP);
}

void WaitForSignal(boost::asio::io_context& context, boost::asio::signal_set& signals) {
  signals.async_wait([](const boost::system::error_code& error, int signal) {
    if (!error) spdlog::info("signal {}: draining", signal);
  });
  context.run();
}

void LogIndexRebuild(const absl::Status& rebuilt) {
  if (rebuilt.ok()) return spdlog::warn("search index was corrupt: rebuilt from the clips");
  spdlog::error("search index is corrupt and cannot be rebuilt: {}",
                std::string(rebuilt.message()));
}

void LogUpgrade(const std::string& store, std::int64_t former, std::int64_t latest) {
  if (former == 0 || former == latest) return;
  spdlog::info("store {} upgraded from version {} to {}: older servers cannot open it", store,
               former, latest);
}

absl::StatusOr<std::unique_ptr<storage::MotionStore>> OpenPostgres(const Settings& settings) {
  MOTIONDB_ASSIGN_OR_RETURN(
      auto store,
      storage::PostgresMotionStore::Open(settings.store_path, {.read_only = settings.read_only}));
  LogUpgrade(store->name(), store->versions().before, store->versions().now);
  return store;
}

absl::StatusOr<std::unique_ptr<storage::MotionStore>> OpenFile(const Settings& settings) {
  const std::string& path = settings.store_path;
  // Open reports errors.
  const int former = settings.read_only ? 0 : storage::ReadStoreVersion(path).value_or(0);
  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::SqliteMotionStore::Open(
                                            path, {.reserve_bytes = settings.disk_reserve_bytes,
                                                   .read_only = settings.read_only,
                                                   .on_index_rebuild = LogIndexRebuild}));
  LogUpgrade(path, former, std::ssize(storage::Migrations()));
  return store;
}

// Opens the store. This upgrades a store of an older version, which is logged, because older
// servers can no longer open it.
absl::StatusOr<std::unique_ptr<storage::MotionStore>> OpenStore(const Settings& settings) {
  const bool is_postgres = storage::IsPostgresUrl(settings.store_path);
  auto store = is_postgres ? OpenPostgres(settings) : OpenFile(settings);
  if (store.ok() && settings.read_only) {
    spdlog::info("store {} opened read-only: changes are refused",
                 storage::WithoutPassword(settings.store_path));
  }
  return store;
}

// As OpenStore. Waits for a PostgreSQL that cannot be reached: after a reboot it may start later.
// Null if a signal arrives meanwhile.
absl::StatusOr<std::unique_ptr<storage::MotionStore>> AwaitStore(const Settings& settings,
                                                                 boost::asio::io_context& context,
                                                                 boost::asio::signal_set& signals) {
  constexpr std::chrono::milliseconds kMaxDelay{2000};
  std::chrono::milliseconds delay{100};
  const bool may_wait = storage::IsPostgresUrl(settings.store_path);
  bool is_ending = false;
  bool has_waited = false;
  signals.async_wait([&](const boost::system::error_code& error, int) { is_ending = !error; });
  auto store = OpenStore(settings);
  while (may_wait && absl::IsUnavailable(store.status()) && !is_ending) {
    if (!std::exchange(has_waited, true)) {
      PrintAlways(settings.log.format, fmt::format("{}; retrying until it can be reached",
                                                   std::string(store.status().message())));
    }
    NotifyServiceManager("EXTEND_TIMEOUT_USEC=60000000\nSTATUS=waiting for the store");
    context.run_for(delay);
    delay = std::min(2 * delay, kMaxDelay);
    if (!is_ending) store = OpenStore(settings);
  }
  signals.cancel();
  context.run();
  context.restart();
  if (is_ending) return nullptr;
  if (has_waited && store.ok()) PrintAlways(settings.log.format, "the store can be reached");
  return store;
}

absl::Status Serve(const Settings& settings) {
  std::optional<AllocationsMayFail> starting(std::in_place);
  // Before the store is created or upgraded: a server that cannot run must not do it.
  MOTIONDB_RETURN_IF_ERROR(InstallMemoryReserve());
  MOTIONDB_RETURN_IF_ERROR(CheckProcessLimits(Workers::ThreadCount(settings.server.engine)));
  // Before any thread starts and before the address is printed, so that every later signal drains.
  boost::asio::io_context context;
  boost::asio::signal_set signals(context);
  AddDrainSignals(signals);

  MOTIONDB_ASSIGN_OR_RETURN(const SecurityConfig plan,
                            DeriveSecurityConfig(settings.server.security, settings.server.listen,
                                                 settings.server.web_listen));
  // At any log level.
  for (const std::string& warning : plan.warnings) PrintAlways(settings.log.format, warning);
  // Before the store, so that a long start can be monitored.
  const std::string store_file =
      storage::IsPostgresUrl(settings.store_path) ? "" : settings.store_path;
  const auto monitor = std::make_shared<Monitor>(MonitorOptions{
      .methods = MethodNames(), .store_path = store_file, .slow_call = settings.log.slow_call});
  MOTIONDB_ASSIGN_OR_RETURN(const auto http,
                            StartHealthServer(settings.http_listen, *monitor, settings.log.format));
  if (http != nullptr && !settings.http_listen.empty()) {
    fmt::print("motiondbd: metrics at http://{}/metrics\n", http->address());
    std::fflush(stdout);
  }
  // Before the store is created or upgraded: a server that cannot listen must not do it.
  MOTIONDB_RETURN_IF_ERROR(CheckListening(settings.server.listen));
  if (const std::string& web = settings.server.web_listen; !web.empty()) {
    MOTIONDB_RETURN_IF_ERROR(CheckListening(web));
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto store, AwaitStore(settings, context, signals));
  if (store == nullptr) {
    spdlog::info("signal while the store was opened: stopping");
    return absl::OkStatus();
  }
  // Never shut down: grpc_shutdown waits for all of gRPC's threads, even for one that did not start
  // because memory was exhausted. Then the store would not be closed.
  grpc_init();
  MOTIONDB_ASSIGN_OR_RETURN(const auto server,
                            Server::Start(std::move(store), settings.server, monitor));
  if (const std::string web = server->web_address(); !web.empty()) {
    fmt::print("motiondbd: HTTP API at {}\n", web);
    spdlog::info("HTTP API at {}", web);
  }
  fmt::print("motiondbd: listening on {}\n", server->address());
  std::fflush(stdout);
  spdlog::info("store {}, listening on {}", storage::WithoutPassword(settings.store_path),
               server->address());

  NotifyServiceManager(fmt::format("READY=1\nSTATUS=listening on {}", server->address()));

  starting.reset();
  WaitForSignal(context, signals);
  NotifyServiceManager("STOPPING=1\nSTATUS=draining");
  server->Drain(settings.grace);
  spdlog::info("drained");
  return absl::OkStatus();
}

// Runs Serve and converts exceptions to a status.
absl::Status ServeWithoutExceptions(const Settings& settings) {
  try {
    return Serve(settings);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        "cannot start: not enough memory for the store and its models; raise the limit (ulimit -v, "
        "MemoryMax)");
  } catch (const std::exception& error) {
    return absl::InternalError(fmt::format("cannot start: {}", error.what()));
  }
}

constexpr int kFailed = 1;
constexpr int kWrongSettings = 2;

int PrintProblems(const std::vector<absl::Status>& problems) {
  for (const absl::Status& problem : problems) {
    fmt::print(stderr, "motiondbd: {}\n", text::SafeText(std::string(problem.message())));
  }
  return kWrongSettings;
}

// Prints each setting and its source in the syntax of the configuration file, then all problems.
int CheckConfig(const SettingsReader& reader) {
  for (const EffectiveSetting& setting : reader.Effective()) {
    const std::string line = fmt::format("{} = {}", setting.key, setting.value);
    fmt::print("{}\n", text::SafeText(fmt::format("{:<48}# {}", line, setting.source)));
  }
  for (const std::string& warning : reader.warnings()) {
    fmt::print(stderr, "motiondbd: {}\n", text::SafeText(warning));
  }
  const std::vector<absl::Status> problems = reader.Check();
  if (!problems.empty()) return PrintProblems(problems);
  const Settings& settings = reader.settings();
  // The same warnings as at a start.
  const auto plan = DeriveSecurityConfig(settings.server.security, settings.server.listen,
                                         settings.server.web_listen);
  if (!plan.ok()) return PrintProblems({plan.status()});
  for (const std::string& warning : plan->warnings) {
    fmt::print(stderr, "motiondbd: {}\n", text::SafeText(warning));
  }
  return 0;
}

int Run(int argc, const char* const* argv) {
  SetUpProcess();
  const std::span<const char* const> arguments(argv + 1, static_cast<std::size_t>(argc - 1));
  if (!arguments.empty() && std::string_view(arguments[0]) == "migrate")
    return RunMigrate(arguments);
  SettingsReader reader;
  const std::vector<absl::Status> problems = reader.Read(argc, argv, ReadEnvironment());
  if (!problems.empty()) {
    PrintProblems(problems);
    fmt::print(stderr, "Try `motiondbd --help`.\n");
    return kWrongSettings;
  }
  switch (reader.task()) {
    case SettingsReader::Task::kHelp:
      fmt::print("{}", reader.Help());
      return 0;
    case SettingsReader::Task::kVersion:
      fmt::print("motiondbd {}\n", MOTIONDB_VERSION);
      return 0;
    case SettingsReader::Task::kCheck:
      return CheckConfig(reader);
    case SettingsReader::Task::kServe:
      break;
  }
  const LogSettings& log = reader.settings().log;
  StartLog(log.format, log.level);
  LogGrpc();
  for (const std::string& warning : reader.warnings()) PrintAlways(log.format, warning);
  const std::vector<absl::Status> violations = reader.CheckForStart();
  for (const absl::Status& problem : violations)
    PrintAlways(log.format, std::string(problem.message()));
  if (!violations.empty()) return kWrongSettings;
  const absl::Status status = ServeWithoutExceptions(reader.settings());
  if (status.ok()) return 0;
  PrintAlways(log.format, std::string(status.message()));
  if (absl::IsDataLoss(status)) {
    PrintAlways(
        log.format,
        "the store is corrupt and cannot be opened: restore a backup into a new store, or copy the "
        "file with its -wal file and create a new store from the output of `sqlite3 COPY "
        ".recover`");
  }
  return kFailed;
}

}  // namespace
}  // namespace motiondb::server

int main(int argc, char** argv) { return motiondb::server::Run(argc, argv); }
