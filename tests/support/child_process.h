// A program that a test starts, talks to by signals and waits for.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace motiondb::tests {

// Killed, if it still runs, when this is destroyed. Not thread-safe.
class ChildProcess {
 public:
  // arguments[0] is the program's path. Its standard error goes to the end of a file, or to this
  // program's own where none is named. Throws std::runtime_error if it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& arguments,
                        const std::string& errors_file = "");
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // The next line of its standard output, without its end; empty at the end of the output.
  std::string ReadLine();
  pid_t pid() const { return pid_; }
  void Signal(int signal);
  // Waits for the end: the exit code, or 128 and the signal that ended it.
  int Wait();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
};

}  // namespace motiondb::tests
