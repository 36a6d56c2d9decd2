// What the operating system knows about this process.
#pragma once

#include <cstdint>

namespace motiondb::server {

struct ProcessFigures {
  std::int64_t resident_bytes = 0;
  std::int64_t virtual_bytes = 0;
  double cpu_seconds = 0;  // user and system, of all threads, since the start
  int thread_count = 0;
  int open_descriptors = 0;
  std::int64_t max_descriptors = 0;
};

// Reads /proc/self; a figure that cannot be read is 0. Thread-safe.
ProcessFigures ReadProcessFigures();

}  // namespace motiondb::server
