#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/planning/floor.h"

namespace motiondb::tests::polygon_check_test {
namespace {

using Catch::Contains;

core::Polygon Corners(std::vector<Eigen::Vector2d> corners) { return {std::move(corners)}; }

std::string Refusal(const core::Polygon& polygon) {
  const absl::Status status = core::CheckPolygon(polygon);
  CHECK(status.ok() == status.message().empty());
  return std::string(status.message());
}

TEST_CASE("CheckPolygon: simple polygons are accepted, in either orientation", "[core][planning]") {
  CHECK(core::CheckPolygon(Corners({{0, 0}, {1, 0}, {0, 1}})).ok());
  CHECK(core::CheckPolygon(Corners({{0, 1}, {1, 0}, {0, 0}})).ok());
  // Concave, with collinear corners.
  CHECK(core::CheckPolygon(Corners({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 0.5}, {0, 2}})).ok());
  // Closed explicitly, and with a duplicate corner.
  CHECK(core::CheckPolygon(Corners({{0, 0}, {1, 0}, {1, 0}, {0, 1}, {0, 0}})).ok());
}

TEST_CASE("CheckPolygon: other polygons are refused with the position", "[core][planning]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(Refusal(Corners({})), Contains("at least 3 different corners, got 0"));
  CHECK_THAT(Refusal(Corners({{0, 0}, {1, 0}})), Contains("at least 3 different corners, got 2"));
  CHECK_THAT(Refusal(Corners({{1, 2}, {1, 2}, {1, 2}})), Contains("corners, got 1"));
  CHECK_THAT(Refusal(Corners({{0, 0}, {1, nan}, {0, 1}})), Contains("corners[1]"));
  // A bow tie, a line forth and back, a spike, and two triangles with a common corner.
  CHECK_THAT(Refusal(Corners({{0, 0}, {1, 1}, {1, 0}, {0, 1}})),
             Contains("corners[0]") && Contains("corners[2]"));
  CHECK_THAT(Refusal(Corners({{0, 0}, {1, 0}, {2, 0}})), Contains("simple polygon"));
  CHECK_THAT(Refusal(Corners({{0, 0}, {2, 0}, {1, 0}, {1, 1}})), Contains("simple polygon"));
  CHECK_THAT(Refusal(Corners({{0, 0}, {1, -1}, {1, 1}, {0, 0}, {-1, 1}, {-1, -1}})),
             Contains("simple polygon"));
}

TEST_CASE("CheckPolygon: 10,000 corners take little time", "[core][planning]") {
  core::Polygon star;
  constexpr int kCorners = 10'000;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    const double radius = i % 2 == 0 ? 1 : 1.001;
    star.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  CHECK(core::CheckPolygon(star).ok());
  std::swap(star.corners[5000], star.corners[5004]);
  CHECK_THAT(Refusal(star), Contains("simple polygon"));
}

}  // namespace
}  // namespace motiondb::tests::polygon_check_test
