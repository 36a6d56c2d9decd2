// Memory of another process: current, peak, and a limit.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace motiondb::tests {

// Return bytes. Throw std::runtime_error if the process has ended.
std::int64_t ResidentMemory(pid_t process);
// Returns the peak resident memory since the last ForgetPeak.
std::int64_t PeakMemory(pid_t process);
void ForgetPeak(pid_t process);

// A memory cgroup (version 1). Removed by the destructor, which must run after its processes have
// ended. Not thread-safe.
class MemoryCgroup {
 public:
  // Throws std::runtime_error with the reason if the cgroup cannot be created.
  explicit MemoryCgroup(std::int64_t limit_bytes);
  ~MemoryCgroup();
  MemoryCgroup(const MemoryCgroup&) = delete;
  MemoryCgroup& operator=(const MemoryCgroup&) = delete;

  void Add(pid_t process);
  // Returns the peak memory of its processes, including cached files.
  std::int64_t peak() const;

 private:
  std::string folder_;
};

}  // namespace motiondb::tests
