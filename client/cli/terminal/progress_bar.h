// A progress bar on standard error. Shows nothing if standard error is not a terminal.
#pragma once

#include <string>

namespace motiondb::client {

class ProgressBar {
 public:
  ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();  // clears the line

  // Draws the bar with `fraction` (0 to 1) and the current activity.
  void Show(double fraction, const std::string& activity);

  // Removes the bar, so that other lines can be printed.
  void Clear();

 private:
  const bool enabled_;
  bool shown_ = false;
};

// Returns the line that Show draws, at most `columns` characters.
std::string ProgressLine(double fraction, const std::string& activity, int columns);

}  // namespace motiondb::client
