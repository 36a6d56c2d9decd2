// Limits the events of each source, for example an address, within a time window. Memory is bounded
// for any number of sources.
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

  // Allows `max_count` events within a `window` that begins with the first event. Keeps at most
  // `capacity` sources: those with the newest windows.
  AttemptLimit(int max_count, std::chrono::milliseconds window, std::size_t capacity = 4096)
      : max_count_(max_count), window_(window), capacity_(capacity) {}

  // Counts an event. Returns whether it is within the limit.
  bool Count(const std::string& source, Clock::time_point now = Clock::now());
  // Returns the time until the source may try again; zero if it may try now.
  std::chrono::milliseconds Wait(const std::string& source,
                                 Clock::time_point now = Clock::now()) const;
  std::size_t size() const;

 private:
  struct Window {
    Clock::time_point began;
    int count = 0;
  };
  void MakeRoom(Clock::time_point now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const int max_count_;
  const std::chrono::milliseconds window_;
  const std::size_t capacity_;
  mutable storage::Mutex mutex_;
  std::unordered_map<std::string, Window> windows_ ABSL_GUARDED_BY(mutex_);
};

// Returns the key of a peer for AttemptLimit: an IPv4 address itself, or the /64 network of an IPv6
// address, because one peer can use every address of its network.
std::string AttemptSource(const std::string& address);

}  // namespace motiondb::server
