// Heavy work never takes every thread.
#include "server/engine/lane.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <condition_variable>
#include <mutex>
#include <vector>

#include "server/engine/workers.h"

namespace motiondb::server {
namespace {

TEST_CASE("Lane: at most its width runs at a time, all of it runs, in order", "[server]") {
  for (const int width : {1, 2, 3}) {
    ThreadPool pool(4);
    std::atomic<int> running{0};
    std::atomic<int> most{0};
    std::mutex mutex;
    std::vector<int> order;
    Lane lane(pool, width);
    for (int i = 0; i < 200; ++i) {
      lane.Post([&, i] {
        const int now = ++running;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) {
        }
        {
          const std::lock_guard lock(mutex);
          order.push_back(i);
        }
        --running;
      });
    }
    pool.Join();
    CHECK(most <= width);
    CHECK(order.size() == 200);
    if (width == 1) CHECK(std::is_sorted(order.begin(), order.end()));
  }
}

TEST_CASE("Workers: light work goes on beside as much heavy work as there is", "[server]") {
  EngineOptions options;
  options.query_threads = 2;
  Workers workers(options);
  std::mutex mutex;
  std::condition_variable changed;
  bool light_is_done = false;
  // Each would wait for ever, were it to keep the light work from running.
  for (int i = 0; i < 8; ++i) {
    workers.PostHeavy([&] {
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return light_is_done; });
    });
  }
  workers.Post([&] {
    const std::lock_guard lock(mutex);
    light_is_done = true;
    changed.notify_all();
  });
  workers.Join();
  CHECK(light_is_done);
}

}  // namespace
}  // namespace motiondb::server
