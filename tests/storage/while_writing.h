// A store that is kept busy writing.
#pragma once

#include <functional>
#include <future>
#include <thread>

#include "storage/motion_store.h"

namespace motiondb::tests {

// Runs `during` while `clip`, whose audit is set here, is being written: other writes wait.
// REQUIRES: it can be added.
inline void WhileWriting(storage::MotionStore& store, storage::NewClip clip,
                         const std::function<void()>& during) {
  std::promise<void> writing;
  std::promise<void> release;
  clip.audit = [&](const storage::ClipRecord&) {
    writing.set_value();
    release.get_future().wait();
    return storage::AuditRecord{.method = "Hold"};
  };
  std::jthread writer([&] { store.AddClip(clip).IgnoreError(); });
  writing.get_future().wait();
  during();
  release.set_value();
}

}  // namespace motiondb::tests
