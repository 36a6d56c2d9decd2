// Runs work on untrusted bytes in a child process with limits.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <iterator>
#include <string>

#include "absl/status/statusor.h"
#include "import/sandbox.h"

namespace motiondb::importer {

// A child process, and what it has written so far.
class Child {
 public:
  // Forks. The child enters the sandbox, writes the result of `work` and exits. `is_sandboxed`
  // false: without sandbox, for debugging. UNAVAILABLE if there is no process. REQUIRES: the
  // calling process has one thread.
  static absl::StatusOr<Child> Start(const std::function<std::string()>& work,
                                     const SandboxLimits& limits, bool is_sandboxed);

  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;
  ~Child();  // kills a running child

  // File descriptor to poll for Step.
  int descriptor() const { return descriptor_; }
  // Reads what is available; `is_readable`: as polled. Returns true when the child has ended, has
  // closed its output, has written too much or is overdue: then call Finish.
  bool Step(bool is_readable);
  // Waits for the end of the process, at most until its deadline, and returns its result.
  // RESOURCE_EXHAUSTED: too much memory, time or output; INTERNAL: it crashed or made a forbidden
  // system call; UNAVAILABLE: it had no sandbox.
  absl::StatusOr<std::string> Finish();

 private:
  Child(pid_t process, int descriptor, const SandboxLimits& limits);

  bool HasWrittenTooMuch() const { return std::ssize(output_) > limits_.result_bytes; }
  bool IsOverdue() const { return std::chrono::steady_clock::now() > deadline_; }
  // Returns the status of waitpid; kills the process at the deadline.
  int AwaitEnd();

  pid_t process_ = -1;
  int descriptor_ = -1;
  SandboxLimits limits_;
  std::chrono::steady_clock::time_point deadline_;
  std::string output_;
  bool was_killed_ = false;
};

// Whether the reader of standard output is gone, so that no answer is needed.
bool OutputIsClosed();

}  // namespace motiondb::importer
