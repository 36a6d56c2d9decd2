// Progress of a long run: a bar on a terminal, otherwise occasional lines. Thread-safe.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "client/cli/terminal/terminal.h"

namespace motiondb::tests {

class Progress {
 public:
  Progress();

  // Begins a stage of `steps` steps.
  void Begin(const std::string& stage, int steps);
  void Step();
  // Removes the bar, so that tables can be printed.
  void Clear();

 private:
  void Show();  // mutex_ is held

  const bool terminal_;
  std::mutex mutex_;
  client::ProgressBar bar_;
  std::string stage_;
  int steps_ = 0;
  int done_ = 0;
  std::chrono::steady_clock::time_point shown_;
};

}  // namespace motiondb::tests
