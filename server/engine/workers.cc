#include "server/engine/workers.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <thread>
#include <utility>

#include "server/engine/shared_loop.h"

namespace motiondb::server {
namespace {

int MachineThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int RequestThreads(const EngineOptions& options) {
  return options.query_threads > 0 ? options.query_threads : MachineThreads();
}

int HeavyThreads(const EngineOptions& options) {
  return options.heavy_threads > 0 ? options.heavy_threads
                                   : std::max(1, RequestThreads(options) - 1);
}

int BuildThreads(const EngineOptions& options) {
  return options.build_threads > 0 ? options.build_threads : std::max(1, MachineThreads() / 2);
}

core::ParallelFor Lend(ThreadPool& pool, int threads) {
  return [&pool, threads](int count, const std::function<void(int)>& body) {
    RunSharedLoop(count, body, threads - 1, [&pool](std::function<void()> help) {
      boost::asio::post(pool.executor(), std::move(help));
    });
  };
}

}  // namespace

int Workers::ThreadCount(const EngineOptions& options) {
  constexpr int kOfOneThread = 4;  // extensions, changes, urgent changes, upkeep
  return RequestThreads(options) + BuildThreads(options) + kOfOneThread;
}

Workers::Workers(const EngineOptions& options)
    : request_threads_(RequestThreads(options)),
      build_threads_(BuildThreads(options)),
      requests_(request_threads_),
      builds_(build_threads_),
      extensions_(1),
      changes_(1),
      urgent_changes_(1),
      upkeep_(1),
      heavy_requests_(requests_, HeavyThreads(options)) {}

Workers::~Workers() { Join(); }

std::function<void()> Workers::Counted(std::atomic<int>& queued, std::function<void()> work) {
  queued.fetch_add(1, std::memory_order_relaxed);
  return [&queued, work = std::move(work)] {
    queued.fetch_sub(1, std::memory_order_relaxed);
    work();
  };
}

void Workers::Post(std::function<void()> work) {
  boost::asio::post(requests_.executor(), Counted(queued_requests_, std::move(work)));
}

void Workers::PostHeavy(const std::string& client, std::function<void()> work) {
  heavy_requests_.Post(client, Counted(queued_heavy_, std::move(work)));
}

void Workers::PostChange(std::function<void()> work) {
  boost::asio::post(changes_.executor(), Counted(queued_changes_, std::move(work)));
}

void Workers::PostUrgentChange(std::function<void()> work) {
  boost::asio::post(urgent_changes_.executor(), Counted(queued_urgent_, std::move(work)));
}

void Workers::PostUpkeep(std::function<void()> work) {
  boost::asio::post(upkeep_.executor(), Counted(queued_upkeep_, std::move(work)));
}

QueueLengths Workers::queued() const {
  return {.requests = queued_requests_.load(std::memory_order_relaxed),
          .heavy_requests = queued_heavy_.load(std::memory_order_relaxed),
          .changes = queued_changes_.load(std::memory_order_relaxed),
          .urgent_changes = queued_urgent_.load(std::memory_order_relaxed),
          .upkeep = queued_upkeep_.load(std::memory_order_relaxed)};
}

core::ParallelFor Workers::build_parallel() { return Lend(builds_, build_threads_); }

core::ParallelFor Workers::request_parallel() { return Lend(requests_, request_threads_); }

void Workers::Join() {
  requests_.Join();
  changes_.Join();
  urgent_changes_.Join();
  upkeep_.Join();
  builds_.Join();
  extensions_.Join();
}

}  // namespace motiondb::server
