// Runs work on untrusted bytes in a child process with limits.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "import/sandbox.h"

namespace motiondb::importer {

// A child process, and what it has written so far.
class Child {
 public:
  // Forks. The child enters the sandbox, writes the result of `work` and exits. `is_sandboxed`
  // false: without sandbox, for debugging. INTERNAL if there is no process. REQUIRES: the calling
  // process has one thread.
  static absl::StatusOr<Child> Start(const std::function<std::string()>& work,
                                     const SandboxLimits& limits, bool is_sandboxed);

  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();  // kills a running child

  // File descriptor to poll for Read.
  int descriptor() const { return descriptor_; }
  // Reads what is available. Returns false at the end.
  bool Read();
  bool IsOverdue() const { return std::chrono::steady_clock::now() > deadline_; }
  // Waits for the end of the process, killing it if it is overdue, and returns its result.
  // RESOURCE_EXHAUSTED: it exceeded its memory or time; INTERNAL: it crashed or made a forbidden
  // system call.
  absl::StatusOr<std::string> Finish();

 private:
  Child(pid_t process, int descriptor, const SandboxLimits& limits);

  pid_t process_ = -1;
  int descriptor_ = -1;
  SandboxLimits limits_;
  std::chrono::steady_clock::time_point deadline_;
  std::string output_;
};

}  // namespace motiondb::importer
