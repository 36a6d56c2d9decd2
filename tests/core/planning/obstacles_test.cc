#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/planning/floor.h"
#include "core/planning/seeded.h"

namespace motiondb::core::obstacles_test {
namespace {

TEST_CASE("Obstacles: distance to a disc is negative inside", "[planning]") {
  const Obstacles obstacles{.discs = {{{1, 2}, 0.5}}};
  CHECK(Distance(obstacles, {1, 2}) == Approx(-0.5));
  CHECK(Distance(obstacles, {1, 3}) == Approx(0.5));
}

TEST_CASE("Obstacles: distance without obstacles is infinite", "[planning]") {
  CHECK(std::isinf(Distance(Obstacles{}, {0, 0})));
}

TEST_CASE("Obstacles: distance to a concave polygon, in either orientation", "[planning]") {
  // An L: the inner corner at (1, 1).
  std::vector<Eigen::Vector2d> corners = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  for (int turn = 0; turn < 2; ++turn) {
    const Obstacles obstacles{.polygons = {{corners}}};
    CHECK(Distance(obstacles, {0.5, 0.5}) == Approx(-0.5));
    CHECK(Distance(obstacles, {1.5, 1.5}) == Approx(0.5));  // outside, in the notch
    CHECK(Distance(obstacles, {-3, 0}) == Approx(3));
    CHECK(Distance(obstacles, {3, -1}) == Approx(std::sqrt(2.0)));
    std::reverse(corners.begin(), corners.end());
  }
}

TEST_CASE("Obstacles: the sign of a distance follows the even-odd rule", "[planning]") {
  // A star-shaped polygon: inside is nearer than the edge in the same direction.
  Polygon star;
  const auto radius = [](double angle) { return 1 + 0.4 * std::sin(5 * angle); };
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * std::numbers::pi * i / 400;
    star.corners.push_back({radius(angle) * std::cos(angle), radius(angle) * std::sin(angle)});
  }
  const Obstacles obstacles{.polygons = {star}};
  SeededSequence random(7);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d p(4 * random.Next() - 2, 4 * random.Next() - 2);
    const double edge = radius(std::atan2(p.y(), p.x()));
    if (std::abs(p.norm() - edge) < 0.01) continue;
    CHECK((Distance(obstacles, p) < 0) == (p.norm() < edge));
  }
}

TEST_CASE("Floor field: without obstacles it is the straight line", "[planning]") {
  const Obstacles none;
  const FloorField field(none, {0, 0}, {3, 4});
  CHECK(field.DistanceToGoal({0, 0}) == Approx(5));
}

TEST_CASE("Floor field: between the path through a wall and the path around it", "[planning]") {
  // A wall across the path, 4 m long; the path around its end is slightly longer than 2 * hypot(1,
  // 2) m.
  const Obstacles wall{.polygons = {{{{0.95, -2}, {1.05, -2}, {1.05, 2}, {0.95, 2}}}},
                       .clearance_m = 0.2};
  const FloorField field(wall, {0, 0}, {2, 0});
  const double round = 2 * std::hypot(0.95, 2.2) + 0.1;
  CHECK(field.DistanceToGoal({0, 0}) < round);
  CHECK(field.DistanceToGoal({0, 0}) > 0.8 * round);
  CHECK(field.DistanceToGoal({1.5, 0}) == Approx(0.5));
  // Far outside the grid the distance is a straight line.
  CHECK(field.DistanceToGoal({-50, 0}) == Approx(52));
}

TEST_CASE("Floor field: clear positions agree with the distance", "[planning]") {
  const Obstacles obstacles{.discs = {{{1, 0.5}, 0.4}},
                            .polygons = {{{{-1, -1}, {0.5, -1.5}, {0.2, -0.4}}}},
                            .clearance_m = 0.25};
  const FloorField field(obstacles, {-2, 0}, {2, 0});
  SeededSequence random(3);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d point(14 * random.Next() - 7, 14 * random.Next() - 7);
    const double distance = random.Next();
    CHECK(field.HasClearance(point, distance) == (Distance(obstacles, point) >= distance));
  }
  const Obstacles none;
  CHECK(FloorField(none, {0, 0}, {1, 0}).HasClearance({0, 0}, 5));
}

TEST_CASE("Floor field: no path into a closed room", "[planning]") {
  Obstacles room{.clearance_m = 0.3};
  const auto wall = [&](double x0, double y0, double x1, double y1) {
    room.polygons.push_back({{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}});
  };
  wall(1, -1, 3, -0.9);
  wall(1, 0.9, 3, 1);
  wall(1, -1, 1.1, 1);
  wall(2.9, -1, 3, 1);
  CHECK(std::isinf(FloorField(room, {0, 0}, {2, 0}).DistanceToGoal({0, 0})));
  room.polygons.pop_back();
  CHECK(std::isfinite(FloorField(room, {0, 0}, {2, 0}).DistanceToGoal({0, 0})));
}

}  // namespace
}  // namespace motiondb::core::obstacles_test
