#include "server/process_limits.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstddef>
#include <exception>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// The store, its readers, the listeners, the thread pools and HTTP take about 50; the rest is for
// connections.
constexpr rlim_t kFewestDescriptors = 128;
// Of gRPC, HTTP, the listener and the watched files.
constexpr int kOtherThreads = 24;
// Address space beside their stacks, to start with. Later calls are refused if it runs out.
constexpr std::size_t kFreeBytes = std::size_t{128} << 20;

absl::Status CheckDescriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= kFewestDescriptors) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      fmt::format("cannot start: the process may open {} files, and at least {} are needed; raise "
                  "the limit (ulimit -n, LimitNOFILE)",
                  limit.rlim_cur, kFewestDescriptors));
}

absl::Status CheckThreads(int count) {
  std::vector<std::thread> threads;
  std::latch all_started(1);
  absl::Status status;
  try {
    threads.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) threads.emplace_back([&] { all_started.wait(); });
    void* const room = mmap(nullptr, kFreeBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED) {
      status = absl::ResourceExhaustedError(
          "cannot start: not enough address space beside the stacks of the threads; raise the "
          "limit "
          "(ulimit -v, LimitAS)");
    } else {
      munmap(room, kFreeBytes);
    }
  } catch (const std::exception& error) {
    status = absl::ResourceExhaustedError(fmt::format(
        "cannot start: {} threads can be started, and {} are needed ({}); raise the limit of "
        "threads (ulimit -u, TasksMax) or of memory (ulimit -v)",
        threads.size(), count, error.what()));
  }
  all_started.count_down();
  for (std::thread& thread : threads) thread.join();
  return status;
}

}  // namespace

void SaveAddressSpace() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  mallopt(M_ARENA_MAX, 2);
}

absl::Status CheckProcessLimits(int work_threads) {
  MOTIONDB_RETURN_IF_ERROR(CheckDescriptors());
  return CheckThreads(work_threads + kOtherThreads);
}

}  // namespace motiondb::server
