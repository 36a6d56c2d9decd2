#include "server/settings/process_limits.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <fstream>
#include <latch>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/motion/error.h"

namespace motiondb::server {

namespace {

// The store, its readers, the listeners, the thread pools and HTTP use about 50; the rest is for
// connections.
constexpr rlim_t kMinDescriptors = 128;
// Threads of gRPC, HTTP, the listener, the watched files and the store.
constexpr int kOtherThreads = 25;
// Address space in addition to the stacks that a start needs. If it runs out later, calls are
// refused.
constexpr std::size_t kFreeBytes = std::size_t{128} << 20;

absl::Status CheckDescriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= kMinDescriptors) {
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError(
      fmt::format("cannot start: the process may open {} files, expected at least {}; raise the "
                  "limit (ulimit -n, LimitNOFILE)",
                  limit.rlim_cur, kMinDescriptors));
}

absl::Status CheckThreads(int count) {
  std::vector<std::thread> threads;
  std::latch all_started(1);
  absl::Status status;
  try {
    threads.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) threads.emplace_back([&] { all_started.wait(); });
    void* const mapped = mmap(nullptr, kFreeBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) {
      status = absl::ResourceExhaustedError(
          "cannot start: not enough address space; raise the limit (ulimit -v, LimitAS)");
    } else {
      munmap(mapped, kFreeBytes);
    }
  } catch (const std::exception& error) {
    status = absl::ResourceExhaustedError(fmt::format(
        "cannot start: the process may start {} threads, expected {} ({}); raise the limit of "
        "threads (ulimit -u, TasksMax) or of memory (ulimit -v)",
        threads.size(), count, error.what()));
  }
  all_started.count_down();
  for (std::thread& thread : threads) thread.join();
  return status;
}

}  // namespace

void LimitMallocArenas() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  mallopt(M_ARENA_MAX, 2);
}

absl::Status CheckProcessLimits(int work_threads) {
  MOTIONDB_RETURN_IF_ERROR(CheckDescriptors());
  return CheckThreads(work_threads + kOtherThreads);
}

namespace {

// Returns the smaller of `max` and the limit in a file of a control group, in bytes; `max` if the
// file does not exist or contains "max".
std::int64_t LimitIn(const std::filesystem::path& file, std::int64_t max) {
  std::ifstream stream(file);
  std::string text;
  std::int64_t limit = 0;
  return stream >> text && absl::SimpleAtoi(text, &limit) ? std::min(limit, max) : max;
}

// Returns the minimum of `max` and the limits of the group and its ancestors below `mount`. In a
// container, the group may be the mount itself.
std::int64_t LimitOfGroup(const std::filesystem::path& mount, std::string group, const char* file,
                          std::int64_t max) {
  while (true) {
    max = LimitIn(mount / std::filesystem::path(group).relative_path() / file, max);
    if (group.empty()) return max;
    group.resize(group.find_last_of('/') == std::string::npos ? 0 : group.find_last_of('/'));
  }
}

}  // namespace

std::int64_t MemoryLimit(const std::string& root) {
  std::int64_t limit = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  // Lines of ID:CONTROLLERS:GROUP. Version 2 has id 0 and no controllers.
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::vector<std::string> parts = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3) continue;
    if (parts[1].empty()) {
      limit = LimitOfGroup(root + "/sys/fs/cgroup", parts[2], "memory.max", limit);
    } else if (parts[1] == "memory") {
      limit =
          LimitOfGroup(root + "/sys/fs/cgroup/memory", parts[2], "memory.limit_in_bytes", limit);
    }
  }
  return limit;
}

}  // namespace motiondb::server
