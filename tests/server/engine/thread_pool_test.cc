// Threads survive exceptions of their work; behavior out of memory.
#include "server/engine/work/thread_pool.h"

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

#include "server/engine/work/memory_reserve.h"

namespace motiondb::server::thread_pool_test {
namespace {

TEST_CASE("ThreadPool: an exception of work ends neither the pool nor a thread", "[server]") {
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

TEST_CASE("ThreadPool: Stop drops work that has not begun", "[server]") {
  std::atomic<int> done = 0;
  {
    ThreadPool pool(1);
    boost::asio::steady_timer timer(pool.executor(), std::chrono::hours(1));
    timer.async_wait([&](const boost::system::error_code&) { ++done; });
    pool.Stop();
  }
  CHECK(done == 0);
}

TEST_CASE("ConcurrencyLimiter: work that throws releases its place", "[server]") {
  ThreadPool pool(2);
  ConcurrencyLimiter lane(pool, 1);
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
// Runs `work` in a child process, because it changes operator new. Returns its exit code; 0:
// success.
int InLittleMemory(int (*work)()) {
  const pid_t child = fork();
  if (child == 0) {
    std::size_t pages = 0;  // already used by the process
    std::ifstream("/proc/self/statm") >> pages;
    const std::size_t limit_bytes = pages * static_cast<std::size_t>(getpagesize()) + (512U << 20);
    const rlimit limit{limit_bytes, limit_bytes};
    if (setrlimit(RLIMIT_AS, &limit) != 0 || !InstallMemoryReserve().ok()) _exit(100);
    _exit(work());
  }
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Allocates memory in blocks of 1 MiB until it fails.
void AllocateAll(std::vector<std::unique_ptr<char[]>>& blocks) {
  const AllocationsMayFail scope;
  try {
    while (true) blocks.push_back(std::make_unique<char[]>(std::size_t{1} << 20));
  } catch (const std::bad_alloc&) {
  }
}

TEST_CASE("MemoryReserve: serves only allocations that must not fail, and is refilled",
          "[server]") {
  CHECK(InLittleMemory([]() -> int {
          std::vector<std::unique_ptr<char[]>> blocks;
          blocks.reserve(1024);
          if (!RefillMemoryReserve().ok()) return 1;
          AllocateAll(blocks);
          if (RefillMemoryReserve().ok()) return 2;  // no memory for C code: work is refused
          // Allocations that must not fail succeed, with 40 of the 64 MiB.
          std::vector<std::unique_ptr<char[]>> further;
          for (int i = 0; i < 40; ++i) {
            further.push_back(std::make_unique<char[]>(std::size_t{1} << 20));
          }
          if (RefillMemoryReserve().ok()) return 3;
          blocks.clear();
          return RefillMemoryReserve().ok() ? 0 : 4;
        }) == 0);
}

TEST_CASE("MemoryReserve: allocations that must not fail wait when it is used up", "[server]") {
  CHECK(InLittleMemory([]() -> int {
          std::vector<std::unique_ptr<char[]>> blocks;
          blocks.reserve(1024);
          std::atomic<bool> all_taken = false;
          std::thread freeing([&] {  // started while there is memory for its stack
            while (!all_taken) std::this_thread::yield();
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
            blocks.clear();
          });
          AllocateAll(blocks);
          all_taken = true;
          const auto large = std::make_unique<char[]>(std::size_t{100} << 20);
          freeing.join();
          return large == nullptr ? 1 : 0;
        }) == 0);
}
#endif

}  // namespace
}  // namespace motiondb::server::thread_pool_test
