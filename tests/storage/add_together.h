// Adds clips at the same time, so that they share a commit.
#pragma once

#include <atomic>
#include <chrono>
#include <new>
#include <thread>
#include <vector>

#include "storage/motion_store.h"

namespace motiondb::tests {

// Result of adding one clip.
struct AddResult {
  absl::StatusOr<storage::ClipRecord> added;
  bool threw = false;
};

// Adds `holder`, whose audit function blocks the writer thread, and meanwhile all `clips`, each on
// its own thread. The writer stays blocked for `hold` after all these threads have started; a clip
// that is not queued by then is added in another commit.
inline std::vector<AddResult> AddTogether(storage::MotionStore& store, storage::NewClip holder,
                                          const std::vector<storage::NewClip>& clips,
                                          std::chrono::milliseconds hold) {
  std::atomic<bool> is_held = false;
  std::atomic<std::size_t> started = 0;
  holder.audit = [&](const storage::ClipRecord&) {
    is_held = true;
    while (started < clips.size()) std::this_thread::yield();
    std::this_thread::sleep_for(hold);
    return storage::AuditRecord{.method = "Hold"};
  };
  std::vector<AddResult> answers(clips.size());
  std::vector<std::jthread> threads;
  threads.emplace_back([&] {
    store.AddClip(holder).IgnoreError();
    is_held = true;  // in case it failed before the audit function
  });
  for (std::size_t i = 0; i < clips.size(); ++i) {
    threads.emplace_back([&, i] {
      while (!is_held) std::this_thread::yield();
      ++started;
      try {
        answers[i].added = store.AddClip(clips[i]);
      } catch (const std::bad_alloc&) {
        answers[i].threw = true;
      }
    });
  }
  threads.clear();  // joins all threads
  return answers;
}

}  // namespace motiondb::tests
