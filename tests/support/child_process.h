// A child process that a test starts, signals and waits for.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace motiondb::tests {

// The destructor kills the process if it still runs. Not thread-safe.
class ChildProcess {
 public:
  // arguments[0] is the path of the program. Its standard error is appended to `errors_file`, or
  // inherited if that is empty. Throws std::runtime_error if the process cannot be started.
  explicit ChildProcess(const std::vector<std::string>& arguments,
                        const std::string& errors_file = "");
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Returns the next line of its standard output without the line feed; empty at the end of the
  // output.
  std::string ReadLine();
  pid_t pid() const { return pid_; }
  void Signal(int signal);
  // Waits for its end. Returns the exit code, or 128 + the signal that killed it.
  int Wait();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

}  // namespace motiondb::tests
