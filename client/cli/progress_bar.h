// A progress bar on standard error, for long work. Shows nothing where standard error is not a
// terminal, so that logs stay clean. Not thread-safe.
#pragma once

#include <string>

namespace motiondb::client {

class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  // clears the line

  // Draws the bar filled to `fraction` (0 to 1) with what is being done beside it.
  void Show(double fraction, const std::string& doing);

  // Takes the bar off the screen, so that other lines can be printed.
  void Clear();

 private:
  const bool enabled_;
  bool shown_ = false;
};

// The line that Show draws: at most `columns` characters.
std::string ProgressLine(double fraction, const std::string& doing, int columns);

}  // namespace motiondb::client
