#include <catch2/catch.hpp>
#include <thread>

#include "server/engine/query/plan_query.h"

namespace motiondb::server::search_clock_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::system_clock;

constexpr auto kNoDeadline = system_clock::time_point::max();

TEST_CASE("SearchClock: a search ends after its limit", "[server][engine]") {
  const SearchClock long_search(60, kNoDeadline);
  CHECK(!long_search.time_up());
  const SearchClock no_time(0, kNoDeadline);
  CHECK(no_time.time_up());
}

TEST_CASE("SearchClock: a call's deadline leaves time for the synthesis", "[server][engine]") {
  CHECK(SearchClock(60, system_clock::now() - milliseconds(1)).time_up());
  const SearchClock clock(60, system_clock::now() + milliseconds(1000));
  while (!clock.time_up()) std::this_thread::sleep_for(milliseconds(1));
  CHECK(clock.total_seconds() > 0.48);
  CHECK(clock.total_seconds() < 0.95);
}

TEST_CASE("SearchClock: the search time stops at EndSearch", "[server][engine]") {
  SearchClock clock(60, kNoDeadline);
  clock.EndSearch();
  const double ended = clock.search_seconds();
  std::this_thread::sleep_for(milliseconds(2));
  CHECK(clock.search_seconds() == ended);
  CHECK(clock.total_seconds() > ended);
}

}  // namespace
}  // namespace motiondb::server::search_clock_test
