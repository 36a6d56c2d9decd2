// Threads for the tree build in tests.
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace motiondb::tests {

// Runs the body's indices on four threads, in descending order.
inline void OnFourThreads(int count, const std::function<void(int)>& body) {
  std::atomic<int> next = count;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int at = --next; at >= 0; at = --next) body(at);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace motiondb::tests
