// motiondbd: opens the store, serves until SIGTERM or SIGINT, and drains.
#include <fmt/format.h>
#include <grpc/support/log.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "core/motion/error.h"
#include "server/command_line.h"
#include "server/server.h"
#include "storage/sqlite/sqlite_motion_store.h"

namespace motiondb::server {
namespace {

void StartLog(const std::string& level) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("motiondbd"));
  spdlog::set_level(spdlog::level::from_str(level));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  // What gRPC cannot do comes back as a status and is told once, in our words.
  gpr_set_log_function([](gpr_log_func_args* line) { spdlog::debug("grpc: {}", line->message); });
}

void WaitForSignal(boost::asio::io_context& context, boost::asio::signal_set& signals) {
  signals.async_wait([](const boost::system::error_code& error, int signal) {
    if (!error) spdlog::info("signal {}: draining", signal);
  });
  context.run();
}

absl::Status Serve(const CommandLine& line) {
  // Before any thread is made and before the address is announced: a signal that comes at any later
  // moment drains.
  boost::asio::io_context context;
  boost::asio::signal_set signals(context, SIGTERM, SIGINT);

  MOTIONDB_ASSIGN_OR_RETURN(auto store, storage::SqliteMotionStore::Open(line.store_path));
  MOTIONDB_ASSIGN_OR_RETURN(const auto server, Server::Start(std::move(store), line.server));
  fmt::print("motiondbd: listening on {}\n", server->address());
  std::fflush(stdout);
  spdlog::info("store {}, listening on {}", line.store_path, server->address());

  WaitForSignal(context, signals);
  server->Drain(line.grace);
  spdlog::info("drained");
  return absl::OkStatus();
}

}  // namespace
}  // namespace motiondb::server

int main(int argc, char** argv) {
  motiondb::server::CommandLine line;
  int exit_code = 0;
  if (!motiondb::server::ParseCommandLine(argc, argv, line, exit_code)) return exit_code;
  motiondb::server::StartLog(line.log_level);
  const absl::Status status = motiondb::server::Serve(line);
  if (status.ok()) return 0;
  fmt::print(stderr, "motiondbd: {}\n", std::string(status.message()));
  return 1;
}
