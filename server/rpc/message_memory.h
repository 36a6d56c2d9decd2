// Memory that calls hold on to: requests as they were read, files on their way in, answers on their
// way out. Thread-safe; outlives its shares.
#pragma once

#include <cstdint>
#include <mutex>
#include <utility>

#include "absl/status/status.h"

namespace motiondb::server {

class MessageMemory {
 public:
  // What one call holds; given back when it is destroyed. Serves one thread at a time.
  class Share {
   public:
    explicit Share(MessageMemory& memory) : memory_(memory) {}
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share();

    // Holds so many bytes in place of those before. RESOURCE_EXHAUSTED, holding what it held, if
    // that is more than there is, saying when to try again if it ever can be.
    absl::Status Hold(std::int64_t bytes);

   private:
    MessageMemory& memory_;
    std::int64_t held_ = 0;
  };

  explicit MessageMemory(std::int64_t limit) : limit_(limit) {}

  std::int64_t held() const;

 private:
  absl::Status Change(std::int64_t from, std::int64_t to);

  const std::int64_t limit_;
  mutable std::mutex mutex_;
  std::int64_t held_ = 0;
};

}  // namespace motiondb::server
