// The cheapest paths, compared with the minimum over all paths.
#include "core/recognition/cheapest_path.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "tests/support/synthetic_states.h"

namespace motiondb::tests::cheapest_path_test {
namespace {

core::MetricFrames StoredFrames(core::FrameMatrix clip) {
  core::MetricFrames stored;
  stored.squared_norms = clip.rowwise().squaredNorm();
  stored.projected = core::SharedRows(std::move(clip));
  return stored;
}

struct PathCost {
  double cost = std::numeric_limits<double>::infinity();
  int first = 0;
};

// Returns for each row the cheapest of all paths that end there, by enumeration.
std::vector<PathCost> EnumeratePaths(const core::FrameMatrix& clip,
                                     const core::FrameMatrix& observed) {
  std::vector<PathCost> cheapest(clip.rows());
  const auto last = static_cast<int>(observed.rows()) - 1;
  std::function<void(int, int, int, double)> follow = [&](int first, int t, int row, double cost) {
    if (row >= clip.rows()) return;
    cost += (observed.row(t) - clip.row(row)).cast<double>().squaredNorm();
    if (t == last) {
      if (cost < cheapest[row].cost) cheapest[row] = {cost, first};
      return;
    }
    follow(first, t + 1, row, cost + core::kWarpCost);
    follow(first, t + 1, row + 1, cost);
    follow(first, t + 1, row + 2, cost + core::kWarpCost);
  };
  for (int first = 0; first < clip.rows(); ++first) follow(first, 0, first, 0);
  return cheapest;
}

core::CheapestPaths Searched(const core::FrameMatrix& clip, const core::FrameMatrix& observed) {
  core::CheapestPaths paths(observed);
  const core::Cancelled never;
  core::ThrottledCancellation cancellation(never);
  REQUIRE(paths.Search(StoredFrames(clip), {0, static_cast<int>(clip.rows())}, cancellation));
  return paths;
}

}  // namespace

TEST_CASE("CheapestPaths: equals the minimum over all paths", "[core][recognition]") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const core::FrameMatrix clip = WanderingStates(1 + static_cast<int>(seed % 23), 4, seed);
    const core::FrameMatrix observed =
        WanderingStates(1 + static_cast<int>(seed % 7), 4, seed + 90);
    const std::vector<PathCost> all = EnumeratePaths(clip, observed);
    const core::CheapestPaths paths = Searched(clip, observed);

    // Of disjoint paths, the cheapest one first.
    std::vector<int> ends(all.size());
    for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = static_cast<int>(i);
    std::stable_sort(ends.begin(), ends.end(),
                     [&](int a, int b) { return all[a].cost < all[b].cost; });
    std::vector<core::PathRows> expected;
    for (const int end : ends) {
      const bool is_free = std::ranges::none_of(expected, [&](const core::PathRows& taken) {
        return all[end].first <= taken.last && taken.first <= end;
      });
      if (is_free) expected.push_back({all[end].first, end, all[end].cost / observed.rows()});
    }
    CHECK(paths.least_cost() == Approx(expected.front().cost).epsilon(1e-4).margin(1e-3));
    const auto found = paths.Disjoint(100);
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      CHECK(found[i].first == expected[i].first);
      CHECK(found[i].last == expected[i].last);
      CHECK(found[i].cost == Approx(expected[i].cost).epsilon(1e-4).margin(1e-3));
    }
    CHECK(paths.Disjoint(1).size() == 1);
  }
}

TEST_CASE("CheapestPaths: follows a motion at other speeds", "[core][recognition]") {
  const core::FrameMatrix clip = 10 * WanderingStates(120, 6, 3);
  const core::FrameMatrix same = clip.middleRows(30, 40);
  const auto at_same_speed = Searched(clip, same).Disjoint(1).front();
  CHECK(at_same_speed.first == 30);
  CHECK(at_same_speed.last == 69);
  CHECK(at_same_speed.cost == Approx(0).margin(0.01));

  // Every fourth frame is left out, then every fourth is doubled.
  std::vector<int> fast, slow;
  for (int t = 30; t < 70; ++t) {
    if (t % 4 != 0) fast.push_back(t);
    slow.push_back(t);
    if (t % 4 == 0) slow.push_back(t);
  }
  for (const std::vector<int>& frames : {fast, slow}) {
    const core::FrameMatrix warped = clip(frames, Eigen::all);
    const auto path = Searched(clip, warped).Disjoint(1).front();
    CHECK(path.first == frames.front());
    CHECK(path.last == 69);
    const auto steps = static_cast<double>(10) / static_cast<double>(frames.size());
    CHECK(path.cost == Approx(steps * core::kWarpCost).epsilon(0.1));
  }
}

TEST_CASE("CheapestPaths: ends soon when cancelled", "[core][recognition]") {
  core::CheapestPaths paths(WanderingStates(4000, 40, 1));
  const core::Cancelled always = [] { return true; };
  core::ThrottledCancellation cancellation(always);
  CHECK_FALSE(paths.Search(StoredFrames(WanderingStates(4000, 40, 2)), {0, 4000}, cancellation));
}

}  // namespace motiondb::tests::cheapest_path_test
