// Time limit and duration of the search for a plan. core has no clock, so the server passes this
// one. One object for each call; not thread-safe.
#pragma once

#include <chrono>

namespace motiondb::server {

class SearchClock {
 public:
  // Starts now. The search ends after `limit_seconds`, or after half of the time until the call's
  // deadline. The rest is for the synthesis of the motion.
  SearchClock(double limit_seconds, std::chrono::system_clock::time_point deadline);

  bool time_up() const { return Clock::now() >= search_end_; }
  // Stops search_seconds().
  void EndSearch() { search_end_seen_ = Clock::now(); }

  // Duration of the search, since the clock started; it still grows until EndSearch.
  double search_seconds() const;
  double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;

  const Clock::time_point start_ = Clock::now();
  Clock::time_point search_end_;
  Clock::time_point search_end_seen_ = Clock::time_point::max();
};

}  // namespace motiondb::server
