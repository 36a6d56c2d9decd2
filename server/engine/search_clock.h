// How long a plan may be searched for, and how long it took. core has no clock: the server lends it
// this one. One object a call; not thread-safe.
#pragma once

#include <chrono>

namespace motiondb::server {

class SearchClock {
 public:
  // Starts now. The search is to end after `limit_seconds`, or when half of what is left until the
  // call's deadline is gone: the rest is for making a motion of what was found.
  SearchClock(double limit_seconds, std::chrono::system_clock::time_point deadline);

  bool time_up() const { return Clock::now() >= search_end_; }
  // From now on search_seconds() stands still.
  void EndSearch() { search_end_seen_ = Clock::now(); }

  // Time of the search, which began when the clock started; all the time where it has not ended.
  double search_seconds() const;
  double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;

  const Clock::time_point start_ = Clock::now();
  Clock::time_point search_end_;
  Clock::time_point search_end_seen_ = Clock::time_point::max();
};

}  // namespace motiondb::server
