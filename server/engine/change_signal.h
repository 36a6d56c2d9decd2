// Notifies listeners that a database or its model has changed. Thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "storage/mutex.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {

class ChangeSignal : public std::enable_shared_from_this<ChangeSignal> {
 public:
  // Short, must not throw, and must not subscribe or end a subscription.
  using Listener = std::function<void()>;

  // Calls its listener after each change while it lives. No call during or after destruction.
  class Subscription {
   public:
    Subscription(std::shared_ptr<ChangeSignal> signal, Listener listener)
        : signal_(std::move(signal)), key_(signal_->Add(std::move(listener))) {}
    ~Subscription() { signal_->Remove(key_); }
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;

   private:
    const std::shared_ptr<ChangeSignal> signal_;
    const std::uint64_t key_;
  };

  std::unique_ptr<Subscription> Subscribe(Listener listener) {
    return std::make_unique<Subscription>(shared_from_this(), std::move(listener));
  }

  // Listeners resume calls of other clients, which must not fail with the caller's work.
  void Notify() {
    const storage::AllocationsMayFail::Pause pause;
    const storage::MutexLock lock(mutex_);
    for (const auto& [key, listener] : listeners_) listener();
  }

 private:
  std::uint64_t Add(Listener listener) {
    const storage::MutexLock lock(mutex_);
    listeners_[next_key_] = std::move(listener);
    return next_key_++;
  }
  void Remove(std::uint64_t key) {
    const storage::MutexLock lock(mutex_);
    listeners_.erase(key);
  }

  storage::Mutex mutex_;
  std::map<std::uint64_t, Listener> listeners_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t next_key_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace motiondb::server
