// Resources that a running server uses, from the kernel and the disk.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace motiondb::tests {

struct ProcessStatistics {
  double memory_mb = 0;  // resident
  int descriptors = 0;
  int threads = 0;
  double store_mb = 0;
  double log_mb = 0;  // the write-ahead log
};

// Throws std::runtime_error if the process has ended.
ProcessStatistics ReadProcessStatistics(pid_t process, const std::string& store);

// Returns the larger value of each field.
ProcessStatistics Largest(const ProcessStatistics& a, const ProcessStatistics& b);

}  // namespace motiondb::tests
