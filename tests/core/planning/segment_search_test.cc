#include "core/planning/segment_search.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/planning/goal.h"
#include "core/planning/seeded.h"
#include "tests/core/planning/walking_database.h"

namespace motiondb::core::segment_search_test {
namespace {

using tests::WalkingDatabase;

constexpr double kLeg = tests::WalkingFigure::kLeg_m;
constexpr int kStart = 10;  // in "straight"

struct Ground {
  Ground() : floor(WalkingDatabase(), kLeg) {}
  SegmentGraph Graph() const { return {WalkingDatabase(), floor, Layer(), {}}; }
  static int Layer() { return WalkingDatabase().layer_count() - 1; }
  StoredFloor floor;
};

absl::StatusOr<FoundPaths> Find(const Ground& ground, const SearchSettings& settings,
                                const Obstacles& obstacles = {}, const PlanControl& control = {}) {
  SegmentGraph graph = ground.Graph();
  const FloorField field(obstacles, {0, 0}, {settings.goal.x, settings.goal.y});
  return SearchSegments(graph, ground.floor, kStart, obstacles, field, settings, control);
}

FloorPose SomeGoal(SeededSequence& random) {
  const double bearing = 2 * (random.Next() - 0.5);
  const double distance = 0.8 + random.Next();
  return {distance * std::cos(bearing), distance * std::sin(bearing),
          bearing + random.Next() - 0.5};
}

// Returns the end of a random path with one join.
FloorPose EndOfRandomPath(SegmentGraph& graph, const StoredFloor& floor, SeededSequence& random) {
  for (;;) {
    const int leave_after = kStart + 2 * graph.half_window() + static_cast<int>(60 * random.Next());
    const auto& joins = graph.Joins(graph.run_of_frame(leave_after));
    if (joins.empty()) continue;
    const Join& join =
        joins[static_cast<std::size_t>(random.Next() * static_cast<double>(joins.size()))].join;
    const int end = join.enter + 30 + static_cast<int>(60 * random.Next());
    if (join.leave < kStart + 2 * graph.half_window() ||
        WalkingDatabase().clip_of_frame(end) != WalkingDatabase().clip_of_frame(join.enter)) {
      continue;
    }
    return PlayedRoot(floor, {.start = kStart, .joins = {join}, .end = end}).back();
  }
}

// Returns the length of the shortest path with at most `joins` joins by enumeration; infinite if
// there is none.
double ShortestByExhaustion(SegmentGraph& graph, const StoredFloor& floor, const FloorPose& goal,
                            SplicedPath path, int joins, double longest) {
  double best = std::numeric_limits<double>::infinity();
  int at = path.joins.empty() ? path.start : path.joins.back().enter + 1;
  for (;; ++at) {
    const int run = graph.run_of_frame(at);
    path.end = at;
    const std::vector<FloorPose> root = PlayedRoot(floor, path);
    const double seconds = static_cast<double>(root.size() - 1) / 60;
    if (seconds > longest) return best;
    const int settled =
        path.joins.empty() ? path.start + 1 : path.joins.back().enter + graph.half_window();
    if (at >= settled) {
      const CorrectedRoot corrected = CorrectRoot(root, goal);
      const GoalError error = ErrorAt(corrected.poses.back(), goal);
      if (error.position_m <= 0.08 && error.heading_rad <= 0.08) best = std::min(best, seconds);
    }
    if (joins > 0) {
      for (const RunJoin& join : graph.Joins(run)) {
        const int since = at - (path.joins.empty() ? path.start : path.joins.back().enter);
        if (join.join.leave != at || since < 2 * graph.half_window()) continue;
        SplicedPath joined = path;
        joined.joins.push_back(join.join);
        best = std::min(
            best, ShortestByExhaustion(graph, floor, goal, std::move(joined), joins - 1, longest));
      }
    }
    if (at == graph.runs()[run].last && !graph.runs()[run].continues) return best;
  }
}

TEST_CASE("Segment search: finds a path whenever enumeration does, and not a much longer one",
          "[planning]") {
  const Ground ground;
  SeededSequence random(11);
  SegmentGraph graph = ground.Graph();
  for (int i = 0; i < 20; ++i) {
    SearchSettings settings;
    settings.goal = EndOfRandomPath(graph, ground.floor, random);
    const double shortest =
        ShortestByExhaustion(graph, ground.floor, settings.goal, {.start = kStart}, 1, 3.5);
    REQUIRE(std::isfinite(shortest));
    const auto found = Find(ground, settings);
    REQUIRE(found.ok());
    INFO("goal " << settings.goal.x << " " << settings.goal.y << " " << settings.goal.heading);
    REQUIRE(found->reached);
    const auto root = PlayedRoot(ground.floor, found->paths.front().path);
    CHECK(static_cast<double>(root.size() - 1) / 60 <= 1.2 * shortest + 0.5);
  }
}

TEST_CASE("Segment search: the root path of a found path reaches the goal", "[planning]") {
  const Ground ground;
  SeededSequence random(5);
  int reached = 0;
  for (int i = 0; i < 20; ++i) {
    SearchSettings settings;
    settings.goal = SomeGoal(random);
    settings.path_count = 3;
    const auto found = Find(ground, settings);
    REQUIRE(found.ok());
    if (!found->reached) continue;
    ++reached;
    double cost = 0;
    for (const FoundPath& path : found->paths) {
      CHECK(path.cost >= cost);  // cheapest first
      cost = path.cost;
      CHECK(path.path.start == kStart);
      const auto corrected = CorrectRoot(PlayedRoot(ground.floor, path.path), settings.goal);
      const GoalError error = ErrorAt(corrected.poses.back(), settings.goal);
      CHECK(error.position_m <= settings.position_tolerance_m);
      CHECK(error.heading_rad <= settings.heading_tolerance_rad);
      int from = path.path.start;
      for (const Join& join : path.path.joins) {  // windows do not overlap
        CHECK(join.leave - from >= 2 * join.half_window);
        from = join.enter;
      }
    }
  }
  CHECK(reached >= 10);
}

TEST_CASE("Segment search: stops as soon as it is within a wide tolerance", "[planning]") {
  const Ground ground;
  SearchSettings settings;
  settings.goal = {2.5, 0, 0};
  settings.position_tolerance_m = 1.5;
  settings.max_duration_seconds = 2;  // 1.4 m at 0.7 m/s
  const auto found = Find(ground, settings);
  REQUIRE(found.ok());
  CHECK(found->reached);
}

TEST_CASE("Segment search: deterministic; another seed gives another path", "[planning]") {
  const Ground ground;
  SearchSettings settings;
  settings.goal = {1.5, 0.5, 0.6};
  const auto first = Find(ground, settings);
  const auto second = Find(ground, settings);
  REQUIRE(first.ok());
  REQUIRE(first->reached);
  CHECK(first->paths[0].cost == second->paths[0].cost);
  CHECK(first->paths[0].path.end == second->paths[0].path.end);
  CHECK(first->effort.expansions == second->effort.expansions);
  int other = 0;
  for (settings.seed = 1; settings.seed <= 5; ++settings.seed) {
    const auto seeded = Find(ground, settings);
    REQUIRE(seeded.ok());
    REQUIRE(seeded->reached);
    other += seeded->paths[0].cost != first->paths[0].cost;
  }
  CHECK(other > 0);
}

TEST_CASE("Segment search: avoids an obstacle with its clearance", "[planning]") {
  const Ground ground;
  SearchSettings settings;
  settings.goal = {3, 0, 0};
  settings.heading_tolerance_rad = 0.5;
  const Obstacles disc{.discs = {{{1.5, 0}, 0.3}}, .clearance_m = 0.2};
  const auto found = Find(ground, settings, disc);
  REQUIRE(found.ok());
  REQUIRE(found->reached);
  const auto corrected = CorrectRoot(PlayedRoot(ground.floor, found->paths[0].path), settings.goal);
  for (const FloorPose& pose : corrected.poses) {
    CHECK(Distance(disc, {pose.x, pose.y}) >= disc.clearance_m);
  }
}

TEST_CASE("Segment search: can be stopped, with the best path so far or none", "[planning]") {
  const Ground ground;
  SearchSettings settings;
  settings.goal = {-6, 5, 2};
  int checks = 0;
  const auto cut = Find(ground, settings, {}, {.time_up = [&] { return ++checks > 5; }});
  REQUIRE(cut.ok());
  CHECK(cut->time_up);
  CHECK(cut->effort.expansions <= 6 * 64);
  CHECK_FALSE(cut->reached);
  REQUIRE(cut->paths.size() == 1);
  CHECK(cut->paths[0].violation > 0);

  const auto cancelled = Find(ground, settings, {}, {.cancelled = [] { return true; }});
  CHECK(cancelled.status().code() == absl::StatusCode::kCancelled);
}

TEST_CASE("Segment search: standing before walking is not treated as a dead end", "[planning]") {
  // A clip that marches on the spot for 3 s without variation, then walks.
  tests::WalkingFigure marching;
  marching.seconds = 3.3;  // three cycles
  marching.speed_m_s = 0;
  MarkerMotion motion = marching.Motion();
  tests::WalkingFigure walking;
  walking.seconds = 3.3;
  const FrameMatrix on = walking.Motion().positions_m;
  const Eigen::Index stood = motion.positions_m.rows();
  motion.positions_m.conservativeResize(stood + on.rows(), Eigen::NoChange);
  motion.positions_m.bottomRows(on.rows()) = on;
  auto states = ComputeStates(tests::WalkerSet(), motion);
  REQUIRE(states.ok());
  const auto model =
      BuildModel({}, tests::WalkerSet(), {{"march", "walk", *std::move(states)}}, RunSerially, {});
  REQUIRE(model.ok());
  const StoredFloor floor(*model, kLeg);
  SegmentGraph graph(*model, floor, model->layer_count(), {});
  SearchSettings settings;
  settings.goal = {1.5, 0, 0};
  const Obstacles none;
  const FloorField field(none, {0, 0}, {1.5, 0});
  const auto found = SearchSegments(graph, floor, 5, none, field, settings, {});
  REQUIRE(found.ok());
  CHECK(found->reached);
}

TEST_CASE("Segment search: reports an exhaustive search", "[planning]") {
  const Ground ground;
  SearchSettings settings;
  settings.goal = {0.3, 0, 0.9};  // no clip rotates on the spot
  settings.max_duration_seconds = 1.5;
  const auto found = Find(ground, settings);
  REQUIRE(found.ok());
  CHECK_FALSE(found->reached);
  CHECK(found->effort.complete);
}

}  // namespace
}  // namespace motiondb::core::segment_search_test
