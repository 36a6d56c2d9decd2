// Where a long run is: a bar on a terminal, now and then a line elsewhere. Safe to call from any
// thread.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "client/cli/progress_bar.h"

namespace motiondb::tests {

class Progress {
 public:
  Progress();

  // A new stage of `steps` steps.
  void Begin(const std::string& stage, int steps);
  void Step();
  // Takes the bar off the screen, so that tables can be printed.
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
