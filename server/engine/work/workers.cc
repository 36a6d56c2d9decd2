#include "server/engine/work/workers.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>
#include <utility>

#include "server/engine/work/shared_loop.h"
#include "server/engine/work/thread_pool.h"

namespace motiondb::server {
namespace {

int MachineThreads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

int RequestThreads(const EngineOptions& options) {
  return options.query_threads > 0 ? options.query_threads : MachineThreads();
}

// Threads for long work such as plans: all but one, which short requests keep.
int HeavyThreads(const EngineOptions& options) { return std::max(1, RequestThreads(options) - 1); }

int BuildThreads(const EngineOptions& options) {
  return options.build_threads > 0 ? options.build_threads : std::max(1, MachineThreads() / 2);
}

class AsioTimer : public Executor::Timer {
 public:
  explicit AsioTimer(const ThreadPool::Executor& executor) : timer_(executor) {}

  void Set(Executor::Clock::time_point time, Executor::Work work) override {
    timer_.expires_at(time);
    timer_.async_wait([work = std::move(work)](const boost::system::error_code& error) {
      if (!error) work();
    });
  }
  void Cancel() override { timer_.cancel(); }

 private:
  boost::asio::steady_timer timer_;
};

// Wraps `work` so that it is counted in its queue until it begins.
Executor::Work Counted(std::atomic<int>& queued, Executor::Work work) {
  queued.fetch_add(1, std::memory_order_relaxed);
  return [&queued, work = std::move(work)] {
    queued.fetch_sub(1, std::memory_order_relaxed);
    work();
  };
}

}  // namespace

int Workers::ThreadCount(const EngineOptions& options) {
  constexpr int kOtherThreads = 4;  // extensions, changes (two), maintenance
  return RequestThreads(options) + BuildThreads(options) + MaxImports() + kOtherThreads;
}

struct Workers::Threads {
  // `in_turn`: maximum threads for work of PostFair.
  Threads(int count, int in_turn)
      : thread_count(count), threads(count), limiter(threads, in_turn) {}
  const int thread_count;
  std::atomic<int> queued{0};
  std::atomic<int> queued_in_turn{0};
  ThreadPool threads;
  ConcurrencyLimiter limiter;
};

Workers::Workers(const EngineOptions& options)
    : pools_{std::make_unique<Threads>(RequestThreads(options), HeavyThreads(options)),
             std::make_unique<Threads>(BuildThreads(options), BuildThreads(options)),
             std::make_unique<Threads>(1, 1),
             std::make_unique<Threads>(2, 1),
             std::make_unique<Threads>(1, 1),
             std::make_unique<Threads>(MaxImports(), MaxImports())} {}

Workers::~Workers() { Join(); }

void Workers::Post(Pool pool, Work work) {
  Threads& to = At(pool);
  boost::asio::post(to.threads.executor(), Counted(to.queued, std::move(work)));
}

void Workers::PostFair(Pool pool, const std::string& client, Work work) {
  Threads& to = At(pool);
  to.limiter.Post(client, Counted(to.queued_in_turn, std::move(work)));
}

std::unique_ptr<Executor::Timer> Workers::MakeTimer(Pool pool) {
  return std::make_unique<AsioTimer>(At(pool).threads.executor());
}

core::ParallelFor Workers::Parallel(Pool pool) {
  return [&threads = At(pool)](int count, const std::function<void(int)>& body) {
    RunSharedLoop(count, body, threads.thread_count - 1, [&threads](Work help) {
      boost::asio::post(threads.threads.executor(), std::move(help));
    });
  };
}

int Workers::queued(Pool pool) const { return At(pool).queued + At(pool).queued_in_turn; }

int Workers::request_threads() const { return At(Pool::kRequests).thread_count; }

int Workers::running_heavy() { return At(Pool::kRequests).limiter.running(); }

QueueLengths Workers::queued() const {
  return {.requests = At(Pool::kRequests).queued,
          .heavy_requests = At(Pool::kRequests).queued_in_turn + queued(Pool::kImports),
          .changes = At(Pool::kChanges).queued_in_turn,
          .urgent_changes = At(Pool::kChanges).queued,
          .maintenance = queued(Pool::kMaintenance)};
}

void Workers::Join() {
  // Each pool before those that it may post to; calls, which also post from requests to imports,
  // have ended. Requests may leave audit entries to the maintenance
  // thread, and all pools request builds and extensions.
  for (const Pool pool : {Pool::kImports, Pool::kRequests, Pool::kChanges, Pool::kMaintenance,
                          Pool::kBuilds, Pool::kExtensions}) {
    At(pool).threads.Join();
  }
}

}  // namespace motiondb::server
