#include "server/engine/work/shared_loop.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

#include "server/engine/work/workers.h"

namespace motiondb::server::shared_loop_test {
namespace {

EngineOptions Threads(int builds) {
  EngineOptions options;
  options.query_threads = 1;
  options.build_threads = builds;
  return options;
}

TEST_CASE("SharedLoop: every index runs once, on any number of threads", "[server]") {
  for (const int threads : {1, 2, 4}) {
    Workers workers(Threads(threads));
    for (const int count : {0, 1, 3, 1000}) {
      std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
      workers.Parallel(Pool::kBuilds)(count, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
      for (const auto& run : runs) REQUIRE(run == 1);
    }
  }
}

TEST_CASE("SharedLoop: nested loops on a full pool end", "[server]") {
  Workers workers(Threads(2));
  const auto parallel = workers.Parallel(Pool::kBuilds);
  std::atomic<int> total{0};
  parallel(8, [&](int) { parallel(8, [&](int) { parallel(8, [&](int) { ++total; }); }); });
  REQUIRE(total == 512);
}

TEST_CASE("SharedLoop: ends without any helper", "[server]") {
  int ran = 0;
  RunSharedLoop(
      5, [&](int) { ++ran; }, 3, [](const std::function<void()>&) {});
  REQUIRE(ran == 5);
}

TEST_CASE("SharedLoop: a late helper does not use the body", "[server]") {
  std::vector<std::function<void()>> late;
  int ran = 0;
  {
    const std::function<void(int)> body = [&](int) { ++ran; };
    RunSharedLoop(4, body, 2, [&](std::function<void()> help) { late.push_back(std::move(help)); });
  }
  REQUIRE(late.size() == 2);
  for (const auto& help : late) help();
  REQUIRE(ran == 4);
}

TEST_CASE("SharedLoop: an exception is rethrown after the rest have ended", "[server]") {
  Workers workers(Threads(2));
  std::atomic<int> ran{0};
  const auto body = [&](int i) {
    ++ran;
    if (i == 3) throw std::runtime_error("three");
  };
  REQUIRE_THROWS_WITH(workers.Parallel(Pool::kBuilds)(20, body), "three");
  REQUIRE(ran == 20);
}

TEST_CASE("Stoppable: starts nothing more once it is stopped", "[server]") {
  Workers workers(Threads(2));
  std::atomic<bool> stop{false};
  const auto parallel = Stoppable(workers.Parallel(Pool::kBuilds), [&] { return stop.load(); });
  std::atomic<int> ran{0};
  parallel(20, [&](int) { ++ran; });
  REQUIRE(ran == 20);
  const auto nested = [&](int) {
    parallel(10, [&](int) {
      if (++ran == 25) stop = true;
    });
  };
  REQUIRE_THROWS_AS(parallel(1000, nested), WorkStopped);
  REQUIRE(ran <= 30);  // bodies that had begun on two threads
  REQUIRE_THROWS_AS(parallel(3, [&](int) { ++ran; }), WorkStopped);
  REQUIRE(ran <= 30);
}

}  // namespace
}  // namespace motiondb::server::shared_loop_test
