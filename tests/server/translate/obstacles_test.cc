#include "server/translate/obstacles.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "motiondb/v1/plan.pb.h"

namespace motiondb::server {
namespace {

using Catch::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

v1::Obstacles DiscAndTriangle() {
  v1::Obstacles message;
  v1::Disc& disc = *message.add_discs();
  disc.mutable_centre()->set_x_m(2);
  disc.mutable_centre()->set_y_m(-1);
  disc.set_radius_m(0.5);
  v1::Polygon& triangle = *message.add_polygons();
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}}) {
    v1::FloorPoint& corner = *triangle.add_corners();
    corner.set_x_m(x);
    corner.set_y_m(y);
  }
  return message;
}

TEST_CASE("Obstacles: come as they are sent", "[server][translate]") {
  v1::Obstacles message = DiscAndTriangle();
  const auto obstacles = ObstaclesFrom("obstacles", message);
  REQUIRE(obstacles.ok());
  REQUIRE(obstacles->discs.size() == 1);
  CHECK(obstacles->discs[0].centre == Eigen::Vector2d(2, -1));
  CHECK(obstacles->discs[0].radius_m == 0.5);
  REQUIRE(obstacles->polygons.size() == 1);
  REQUIRE(obstacles->polygons[0].corners.size() == 3);
  CHECK(obstacles->polygons[0].corners[2] == Eigen::Vector2d(0, 1));
  CHECK(obstacles->clearance_m == 0.3);
  message.set_clearance_m(0);
  CHECK(ObstaclesFrom("obstacles", message)->clearance_m == 0);
  CHECK(ObstaclesFrom("obstacles", {})->empty());
}

TEST_CASE("Obstacles: every wrong one is named", "[server][translate]") {
  const auto expect = [](const std::string& field, const auto& change) {
    v1::Obstacles message = DiscAndTriangle();
    change(message);
    const absl::Status status = ObstaclesFrom("obstacles", message).status();
    CHECK(absl::IsInvalidArgument(status));
    CHECK_THAT(std::string(status.message()), StartsWith("obstacles" + field + ": "));
  };
  expect(".clearance_m", [](auto& o) { o.set_clearance_m(-0.1); });
  expect(".clearance_m", [](auto& o) { o.set_clearance_m(kNan); });
  expect(".discs[0].radius_m", [](auto& o) { o.mutable_discs(0)->set_radius_m(0); });
  expect(".discs[0].radius_m", [](auto& o) { o.mutable_discs(0)->set_radius_m(kNan); });
  expect(".discs[0].centre", [](auto& o) { o.mutable_discs(0)->clear_centre(); });
  expect(".discs[0].centre.y_m",
         [](auto& o) { o.mutable_discs(0)->mutable_centre()->set_y_m(1 / 0.0); });
  expect(".discs[1].centre", [](auto& o) { o.add_discs(); });
  expect(".polygons[0].corners",
         [](auto& o) { o.mutable_polygons(0)->mutable_corners()->RemoveLast(); });
  expect(".polygons[0].corners[1].x_m",
         [](auto& o) { o.mutable_polygons(0)->mutable_corners(1)->set_x_m(kNan); });
  expect(".polygons[1].corners", [](auto& o) { o.add_polygons(); });
  expect(".polygons[0].corners", [](auto& o) {  // crosses itself
    v1::FloorPoint& corner = *o.mutable_polygons(0)->add_corners();
    corner.set_x_m(1);
    corner.set_y_m(1);
  });
  expect("", [](auto& o) {
    for (int i = 0; i < 1000; ++i) o.add_discs();
  });
  expect(".polygons", [](auto& o) {
    for (int i = 0; i < 10'000; ++i) o.mutable_polygons(0)->add_corners();
  });
}

}  // namespace
}  // namespace motiondb::server
