// Heavy work never uses all threads.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "server/engine/work/thread_pool.h"
#include "server/engine/work/workers.h"

namespace motiondb::server::concurrency_limiter_test {
namespace {

TEST_CASE("ConcurrencyLimiter: runs all work in order, at most `width` at a time", "[server]") {
  for (const int width : {1, 2, 3}) {
    ThreadPool pool(4);
    std::atomic<int> running{0};
    std::atomic<int> peak{0};
    std::mutex mutex;
    std::vector<int> order;
    ConcurrencyLimiter limiter(pool, width);
    for (int i = 0; i < 200; ++i) {
      limiter.Post("", [&, i] {
        const int now = ++running;
        for (int seen = peak; now > seen && !peak.compare_exchange_weak(seen, now);) {
        }
        {
          const std::lock_guard lock(mutex);
          order.push_back(i);
        }
        --running;
      });
    }
    pool.Join();
    CHECK(peak <= width);
    CHECK(order.size() == 200);
    if (width == 1) CHECK(std::is_sorted(order.begin(), order.end()));
  }
}

TEST_CASE("ConcurrencyLimiter: clients take turns, also if one has a long queue", "[server]") {
  ThreadPool pool(1);
  ConcurrencyLimiter limiter(pool, 1);
  std::string order;
  std::promise<void> all_posted;
  limiter.Post("a", [&] { all_posted.get_future().wait(); });
  for (int i = 0; i < 100; ++i) limiter.Post("a", [&] { order += 'a'; });
  for (int i = 0; i < 2; ++i) limiter.Post("b", [&] { order += 'b'; });
  limiter.Post("c", [&] { order += 'c'; });
  all_posted.set_value();
  pool.Join();
  CHECK(order.size() == 103);
  CHECK(order.substr(0, 6) == "abcaba");
}

TEST_CASE("ConcurrencyLimiter: a call in several pieces lets others run in between", "[server]") {
  ThreadPool pool(1);
  ConcurrencyLimiter limiter(pool, 1);
  std::string order;
  int remaining = 50;
  std::promise<void> other_posted;
  std::function<void()> piece = [&] {
    order += 'a';
    if (--remaining > 0) limiter.Post("a", piece);
  };
  limiter.Post("a", [&] {
    other_posted.get_future().wait();
    piece();
  });
  limiter.Post("b", [&] { order += 'b'; });
  other_posted.set_value();
  pool.Join();
  CHECK(order.size() == 51);
  CHECK(order.find('b') <= 2);
}

TEST_CASE("Workers: light work runs beside any amount of work that takes turns", "[server]") {
  const Pool pool = GENERATE(Pool::kRequests, Pool::kChanges);
  EngineOptions options;
  options.query_threads = 2;
  Workers workers(options);
  std::mutex mutex;
  std::condition_variable changed;
  bool light_is_done = false;
  // Each waits for the light work: if they took all threads, this would deadlock.
  for (int i = 0; i < 8; ++i) {
    workers.PostFair(pool, "", [&] {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return light_is_done; });
    });
  }
  CHECK(workers.queued(pool) >= 7);
  workers.Post(pool, [&] {
    const std::lock_guard lock(mutex);
    light_is_done = true;
    changed.notify_all();
  });
  workers.Join();
  CHECK(light_is_done);
  CHECK(workers.queued(pool) == 0);
}

}  // namespace
}  // namespace motiondb::server::concurrency_limiter_test
