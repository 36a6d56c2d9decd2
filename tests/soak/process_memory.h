// Memory of another process: what it takes now and at most, and a limit on it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace motiondb::tests {

// Bytes. Throw std::runtime_error if the process is gone.
std::int64_t ResidentMemory(pid_t process);
// The most that was resident since the last ForgetPeak.
std::int64_t PeakMemory(pid_t process);
void ForgetPeak(pid_t process);

// A memory cgroup (version 1) of its own. Removed when it is destroyed, which must be after the
// processes in it ended. Not thread-safe.
class MemoryCgroup {
 public:
  // Throws std::runtime_error, saying why, where none can be made.
  explicit MemoryCgroup(std::int64_t limit_bytes);
  ~MemoryCgroup();
  MemoryCgroup(const MemoryCgroup&) = delete;
  MemoryCgroup& operator=(const MemoryCgroup&) = delete;

  void Add(pid_t process);
  // The most memory that its processes had, with cached files.
  std::int64_t peak() const;

 private:
  std::string folder_;
};

}  // namespace motiondb::tests
