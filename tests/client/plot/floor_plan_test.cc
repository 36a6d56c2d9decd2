#include "client/cli/plot/floor_plan.h"

#include <tinyxml2.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "client/cli/plot/picture.h"
#include "tests/client/planned_motion.h"
#include "tests/client/plot/svg_elements.h"

namespace motiondb::tests::floor_plan_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;

TEST_CASE("FloorPlan: the path, with a pose every 1/6 s", "[client][cli]") {
  const std::string svg = SvgOf(FloorPlanPicture(QuarterCircleRequest(), QuarterCirclePlan()));
  auto floor = ElementsInGroups(svg);
  CHECK(floor["polyline.path"] == 1);
  CHECK(floor["circle.pose"] == 13);   // 2 s, and the first frame
  CHECK(floor["line.heading"] == 14);  // 13 poses and the end
  CHECK(floor["circle.end"] == 1);
  CHECK(floor["circle.tolerance"] == 1);
  CHECK(floor["path.wedge"] == 1);
  CHECK(floor["circle.start"] == 1);
  CHECK(floor.count("polyline.other") == 0);
  CHECK_THAT(svg, Contains("EXACT: from here to 1.00, 1.00, heading 1.57 rad") &&
                      Contains("2.00 s, 1.57 m, ends 0.021 m and 0.012 rad from the goal, "
                               "clearance 0.42 m"));
  CHECK_THAT(svg, !Contains("nan") && !Contains("inf") && !Contains("-0.00"));
  CHECK(svg == SvgOf(FloorPlanPicture(QuarterCircleRequest(), QuarterCirclePlan())));
}

TEST_CASE("FloorPlan: alternatives and obstacles", "[client][cli]") {
  v1::PlanRequest request = QuarterCircleRequest();
  v1::Disc& disc = *request.mutable_obstacles()->add_discs();
  disc.mutable_centre()->set_x_m(0.2);
  disc.mutable_centre()->set_y_m(0.9);
  disc.set_radius_m(0.1);
  v1::Polygon& polygon = *request.mutable_obstacles()->add_polygons();
  for (const auto& [x, y] : {std::pair{1.4, 0.0}, {2.0, 0.0}, {1.7, 0.5}}) {
    v1::FloorPoint& corner = *polygon.add_corners();
    corner.set_x_m(x);
    corner.set_y_m(y);
  }
  v1::PlanResponse response = QuarterCirclePlan();
  *response.add_alternatives() = QuarterCircle(1.05);
  *response.add_alternatives() = QuarterCircle(0.95);
  auto floor = ElementsInGroups(SvgOf(FloorPlanPicture(request, response)));
  CHECK(floor["polyline.other"] == 2);
  CHECK(floor["circle.other-pose"] == 26);
  CHECK(floor["circle.obstacle"] == 1);
  CHECK(floor["polygon.obstacle"] == 1);
  CHECK(floor["circle.clearance"] == 1);
  CHECK(floor["polygon.clearance"] == 1);
  request.mutable_obstacles()->set_clearance_m(0);
  CHECK(ElementsInGroups(SvgOf(FloorPlanPicture(request, response))).count("circle.clearance") ==
        0);
}

TEST_CASE("FloorPlan: draws the floor without a motion", "[client][cli]") {
  v1::PlanResponse response;
  response.set_outcome(v1::PLAN_OUTCOME_UNREACHABLE);
  response.set_missing("<too far> & \"behind\" the \x01 wall");
  v1::PlanRequest request = QuarterCircleRequest();
  request.set_heading_tolerance_rad(4);
  const std::string svg = SvgOf(FloorPlanPicture(request, response));
  auto floor = ElementsInGroups(svg);
  CHECK(floor.count("polyline.path") == 0);
  CHECK(floor["circle.wedge"] == 1);
  CHECK_THAT(svg, Contains("&lt;too far&gt; &amp; &quot;behind&quot; the \xEF\xBF\xBD wall"));
}

TEST_CASE("FloorPlan: distant obstacles, NaN and long texts are harmless", "[client][cli]") {
  v1::PlanRequest request = QuarterCircleRequest();
  v1::Disc& disc = *request.mutable_obstacles()->add_discs();
  disc.mutable_centre()->set_x_m(5000);
  disc.set_radius_m(4990);
  v1::PlanResponse response = QuarterCirclePlan();
  response.mutable_motion()->mutable_root(7)->set_x_m(std::numeric_limits<double>::quiet_NaN());
  response.set_missing(std::string(1000, 'x'));
  const std::string svg = SvgOf(FloorPlanPicture(request, response));
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("xxx...</text>"));
  tinyxml2::XMLDocument document;
  document.Parse(svg.c_str());
  CHECK(document.RootElement()->DoubleAttribute("width") < 1200);
  CHECK(document.RootElement()->DoubleAttribute("height") < 1000);
}

TEST_CASE("FloorView: one scale, within the limits", "[client][cli]") {
  for (const auto& bounds : {FloorBounds{0, 4, 0, 1}, FloorBounds{0, 0, 0, 0},
                             FloorBounds{-1, 0, -900, 100}, FloorBounds{0, 1000, 0, 1}}) {
    const FloorView view(bounds, 70, 80, {});
    CHECK(view.frame().width >= 519.9);
    CHECK(view.frame().width <= 860.1);
    CHECK(view.frame().height >= 259.9);
    CHECK(view.frame().height <= 620.1);
    CHECK(view.X(bounds.min_x) > 70);
    CHECK(view.X(bounds.max_x) < 70 + view.frame().width);
    CHECK(view.Y(bounds.max_y) > 80);
    CHECK(view.Y(bounds.min_y) < 80 + view.frame().height);
    CHECK(view.X(1) - view.X(0) == Approx(view.Y(0) - view.Y(1)));
    CHECK(view.Pixels(view.TickStep()) >= 80);
    CHECK(view.Pixels(view.TickStep()) <= 201);
  }
  CHECK(Ticks(-0.25, 0.31, 0.1).size() == 6);
}

TEST_CASE("Svg: number format and escaped text", "[client][cli]") {
  CHECK(SvgNumber(-0.0001) == "0.00");
  CHECK(SvgNumber(1.005e3) == "1005.00");
  CHECK(SvgNumber(std::numeric_limits<double>::infinity()) == "0.00");
  CHECK(SvgText("a<b>&\"c\"\n\x7f\xc3\xa4") == "a&lt;b&gt;&amp;&quot;c&quot; \xEF\xBF\xBD\xc3\xa4");
  CHECK(SvgText("\xff") == "\xEF\xBF\xBD");
}

}  // namespace
}  // namespace motiondb::tests::floor_plan_test
