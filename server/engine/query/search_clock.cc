#include "server/engine/query/search_clock.h"

#include <algorithm>

namespace motiondb::server {
namespace {

constexpr double kSearchShare = 0.5;  // share of the time until the deadline

double Seconds(std::chrono::duration<double> time) { return time.count(); }

}  // namespace

SearchClock::SearchClock(double limit_seconds, std::chrono::system_clock::time_point deadline) {
  // In seconds: the deadline of a call without one would overflow the clock's ticks.
  const double remaining = Seconds(deadline.time_since_epoch()) -
                           Seconds(std::chrono::system_clock::now().time_since_epoch());
  const double allowed = std::min(limit_seconds, std::max(0.0, kSearchShare * remaining));
  search_end_ =
      start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(allowed));
}

double SearchClock::search_seconds() const {
  return Seconds(std::min(Clock::now(), search_end_seen_) - start_);
}

double SearchClock::total_seconds() const { return Seconds(Clock::now() - start_); }

}  // namespace motiondb::server
