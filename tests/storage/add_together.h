// Clips that are added at the same time, so that they share a commit.
#pragma once

#include <atomic>
#include <chrono>
#include <new>
#include <thread>
#include <vector>

#include "storage/motion_store.h"

namespace motiondb::tests {

// What became of one.
struct AddAnswer {
  absl::StatusOr<storage::ClipRecord> added;
  bool threw = false;
};

// Adds `holder`, whose audit is set here, and while that holds the writer all of `clips`, each on a
// thread of its own. `hold` is how long they are waited for once they are on their way; a clip that
// is later than that is added alone.
inline std::vector<AddAnswer> AddTogether(storage::MotionStore& store, storage::NewClip holder,
                                          const std::vector<storage::NewClip>& clips,
                                          std::chrono::milliseconds hold) {
  std::atomic<bool> is_held = false;
  std::atomic<std::size_t> on_their_way = 0;
  holder.audit = [&](const storage::ClipRecord&) {
    is_held = true;
    while (on_their_way < clips.size()) std::this_thread::yield();
    std::this_thread::sleep_for(hold);
    return storage::AuditRecord{.method = "Hold"};
  };
  std::vector<AddAnswer> answers(clips.size());
  std::vector<std::jthread> threads;
  threads.emplace_back([&] {
    store.AddClip(holder).IgnoreError();
    is_held = true;  // it may have failed before
  });
  for (std::size_t i = 0; i < clips.size(); ++i) {
    threads.emplace_back([&, i] {
      while (!is_held) std::this_thread::yield();
      ++on_their_way;
      try {
        answers[i].added = store.AddClip(clips[i]);
      } catch (const std::bad_alloc&) {
        answers[i].threw = true;
      }
    });
  }
  threads.clear();  // ended, all of them
  return answers;
}

}  // namespace motiondb::tests
