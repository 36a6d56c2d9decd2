#include "tests/support/threads.h"

#include <atomic>
#include <ctime>
#include <thread>
#include <vector>

namespace motiondb::tests {

core::ParallelFor RunOnThreads(int jobs) {
  if (jobs <= 1) return core::RunSerially;
  return [jobs](int count, const std::function<void(int)>& body) {
    std::atomic<int> next{0};
    std::vector<std::jthread> threads;
    for (int j = 0; j < jobs; ++j) {
      threads.emplace_back([&] {
        for (int i = next++; i < count; i = next++) body(i);
      });
    }
  };
}

double ThreadCpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace motiondb::tests
