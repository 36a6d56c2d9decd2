// Blocks the writer of a store.
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <future>
#include <thread>

#include "absl/cleanup/cleanup.h"
#include "storage/motion_store.h"

namespace motiondb::tests {

// Runs `during` while the writer is blocked by adding `clip`, whose audit function is set here:
// other writes wait. REQUIRES: the clip can be added.
inline void WithBlockedWriter(storage::MotionStore& store, storage::NewClip clip,
                              const std::function<void()>& during) {
  std::promise<bool> writing;
  std::promise<void> release;
  clip.audit = [&](const storage::ClipRecord&) {
    writing.set_value(true);
    release.get_future().wait();
    return storage::AuditRecord{.method = "Hold"};
  };
  std::jthread writer([&] {
    if (!store.AddClip(clip).ok()) writing.set_value(false);
  });
  REQUIRE(writing.get_future().get());
  // Releases the thread even if `during` throws.
  const absl::Cleanup end = [&] { release.set_value(); };
  during();
}

}  // namespace motiondb::tests
