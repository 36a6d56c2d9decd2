#include "server/engine/workers.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <latch>
#include <memory>
#include <thread>
#include <utility>

#include "server/engine/shared_loop.h"

namespace motiondb::server {
namespace {

// A tenth of what a request thread gets of a core that both want.
constexpr int kBuildNice = 10;

int MachineThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int RequestThreads(const EngineOptions& options) {
  return options.query_threads > 0 ? options.query_threads : MachineThreads();
}

int BuildThreads(const EngineOptions& options) {
  return options.build_threads > 0 ? options.build_threads : std::max(1, MachineThreads() / 2);
}

// All threads of a pool, as Linux has it. Where the system refuses, they run as the rest.
void GiveWay(boost::asio::thread_pool& pool, int threads) {
  // Each thread waits for the others, so that every one of them takes one.
  const auto everyone = std::make_shared<std::latch>(threads);
  for (int i = 0; i < threads; ++i) {
    boost::asio::post(pool, [everyone] {
      const auto thread = static_cast<id_t>(gettid());
      (void)setpriority(PRIO_PROCESS, thread, getpriority(PRIO_PROCESS, thread) + kBuildNice);
      everyone->arrive_and_wait();
    });
  }
}

core::ParallelFor Lend(boost::asio::thread_pool& pool, int threads) {
  return [&pool, threads](int count, const std::function<void(int)>& body) {
    RunSharedLoop(count, body, threads - 1,
                  [&pool](std::function<void()> help) { boost::asio::post(pool, help); });
  };
}

}  // namespace

Workers::Workers(const EngineOptions& options)
    : request_threads_(RequestThreads(options)),
      build_threads_(BuildThreads(options)),
      requests_(static_cast<std::size_t>(request_threads_)),
      builds_(static_cast<std::size_t>(build_threads_)),
      extensions_(1) {
  GiveWay(builds_, build_threads_);
  GiveWay(extensions_, 1);
}

Workers::~Workers() { Join(); }

void Workers::Post(std::function<void()> work) { boost::asio::post(requests_, std::move(work)); }

core::ParallelFor Workers::build_parallel() { return Lend(builds_, build_threads_); }

core::ParallelFor Workers::request_parallel() { return Lend(requests_, request_threads_); }

void Workers::Join() {
  requests_.join();
  builds_.join();
  extensions_.join();
}

}  // namespace motiondb::server
