// A store that is kept busy writing.
#pragma once

#include <catch2/catch.hpp>
#include <functional>
#include <future>
#include <thread>

#include "absl/cleanup/cleanup.h"
#include "storage/motion_store.h"

namespace motiondb::tests {

// Runs `during` while `clip`, whose audit is set here, is being written: other writes wait.
// REQUIRES: it can be added.
inline void WhileWriting(storage::MotionStore& store, storage::NewClip clip,
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
  // Whatever it throws: the thread ends before the test does.
  const absl::Cleanup end = [&] { release.set_value(); };
  during();
}

}  // namespace motiondb::tests
