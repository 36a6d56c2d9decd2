// Threads that outlive what their work throws, and memory that runs out.
#include "server/engine/thread_pool.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/engine/lane.h"
#include "server/engine/memory_reserve.h"

namespace motiondb::server::thread_pool_test {
namespace {

TEST_CASE("ThreadPool: work that throws ends neither the pool nor a thread of it", "[server]") {
  ThreadPool pool(1);
  std::atomic<int> done = 0;
  boost::asio::steady_timer timer(pool.executor(), std::chrono::milliseconds(1));
  timer.async_wait([](const boost::system::error_code&) { throw std::bad_alloc(); });
  for (int i = 0; i < 10; ++i) {
    boost::asio::post(pool.executor(), [] { throw std::runtime_error("no"); });
    boost::asio::post(pool.executor(), [&] { ++done; });
  }
  pool.Join();
  CHECK(done == 10);
}

TEST_CASE("ThreadPool: Stop drops what has not begun", "[server]") {
  std::atomic<int> done = 0;
  {
    ThreadPool pool(1);
    boost::asio::steady_timer timer(pool.executor(), std::chrono::hours(1));
    timer.async_wait([&](const boost::system::error_code&) { ++done; });
    pool.Stop();
  }
  CHECK(done == 0);
}

TEST_CASE("Lane: work that throws gives its place back", "[server]") {
  ThreadPool pool(2);
  Lane lane(pool, 1);
  std::atomic<int> done = 0;
  for (int i = 0; i < 5; ++i) {
    lane.Post("", [] { throw std::bad_alloc(); });
    lane.Post("", [&] { ++done; });
  }
  pool.Join();
  CHECK(done == 5);
  CHECK(lane.running() == 0);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// In a process of its own: it changes what operator new does. Its exit code, 0 where all is well.
int InLittleMemory(int (*work)()) {
  const pid_t child = fork();
  if (child == 0) {
    std::size_t pages = 0;  // that the process has already
    std::ifstream("/proc/self/statm") >> pages;
    const std::size_t most = pages * static_cast<std::size_t>(getpagesize()) + (512U << 20);
    const rlimit limit{most, most};
    if (setrlimit(RLIMIT_AS, &limit) != 0 || !InstallMemoryReserve().ok()) _exit(100);
    _exit(work());
  }
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Takes memory, a MiB at a time, until there is none.
void TakeAll(std::vector<std::unique_ptr<char[]>>& taken) {
  const AllocationsMayFail scope;
  try {
    while (true) taken.push_back(std::make_unique<char[]>(std::size_t{1} << 20));
  } catch (const std::bad_alloc&) {
  }
}

TEST_CASE("MemoryReserve: serves only those who cannot fail, and is filled again", "[server]") {
  CHECK(InLittleMemory([]() -> int {
          std::vector<std::unique_ptr<char[]>> taken;
          taken.reserve(1024);
          if (!RefillMemoryReserve().ok()) return 1;
          TakeAll(taken);
          if (RefillMemoryReserve().ok()) return 2;  // no room for C code: work is refused
          // What cannot fail goes on, with 40 of the 64 MiB.
          std::vector<std::unique_ptr<char[]>> further;
          for (int i = 0; i < 40; ++i) {
            further.push_back(std::make_unique<char[]>(std::size_t{1} << 20));
          }
          if (RefillMemoryReserve().ok()) return 3;
          taken.clear();
          return RefillMemoryReserve().ok() ? 0 : 4;
        }) == 0);
}

TEST_CASE("MemoryReserve: who cannot fail waits for others once it is used up", "[server]") {
  CHECK(InLittleMemory([]() -> int {
          std::vector<std::unique_ptr<char[]>> taken;
          taken.reserve(1024);
          std::atomic<bool> all_taken = false;
          std::thread freeing([&] {  // started while there is memory for its stack
            while (!all_taken) std::this_thread::yield();
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            taken.clear();
          });
          TakeAll(taken);
          all_taken = true;
          const auto large = std::make_unique<char[]>(std::size_t{100} << 20);
          freeing.join();
          return large == nullptr ? 1 : 0;
        }) == 0);
}
#endif

}  // namespace
}  // namespace motiondb::server::thread_pool_test
