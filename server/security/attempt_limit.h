// Counts what a source, for example an address, did within a stretch of time, so that it can be
// refused when it is too much. Its memory is bounded however many sources there are. Thread-safe.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <unordered_map>

#include "storage/mutex.h"

namespace motiondb::server {

class AttemptLimit {
 public:
  using Clock = std::chrono::steady_clock;

  // At most `most` within a `window` that begins with the first; at most `capacity` sources are
  // remembered, those that began last.
  AttemptLimit(int most, std::chrono::milliseconds window, std::size_t capacity = 4096)
      : most_(most), window_(window), capacity_(capacity) {}

  // Counts one more. Returns whether it was within the limit.
  bool Count(const std::string& source, Clock::time_point now = Clock::now());
  // How long until the source may try again; zero if it may now.
  std::chrono::milliseconds Wait(const std::string& source,
                                 Clock::time_point now = Clock::now()) const;
  std::size_t size() const;

 private:
  struct Window {
    Clock::time_point began;
    int count = 0;
  };
  void MakeRoom(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const int most_;
  const std::chrono::milliseconds window_;
  const std::size_t capacity_;
  mutable storage::Mutex mutex_;
  std::unordered_map<std::string, Window> windows_ ABSL_GUARDED_BY(mutex_);
};

// What stands for a peer in such counts: the address itself, or the network of an IPv6 address (64
// bits), of which a peer may have as many addresses as it likes.
std::string SourceOf(const std::string& address);

}  // namespace motiondb::server
