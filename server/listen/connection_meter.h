// Counts the connections of a listener. Thread-safe.
#pragma once

#include <atomic>
#include <cstdint>

namespace motiondb::server {

struct ConnectionMeter {
  std::atomic<int> open = 0;
  std::atomic<std::int64_t> refused = 0;  // no descriptor, or too many of one address
  std::atomic<std::int64_t> ended = 0;    // closed by the server: client error or out of memory
};

}  // namespace motiondb::server
