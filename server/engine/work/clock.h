// The wall clock in the format of the store.
#pragma once

#include <chrono>
#include <cstdint>

namespace motiondb::server {

// Microseconds since the Unix epoch.
inline std::int64_t NowMicroseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace motiondb::server
