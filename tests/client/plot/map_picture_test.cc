#include "client/cli/picture/map_picture.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "client/cli/picture/estimate_picture.h"
#include "tests/client/plot/recognition_answers.h"
#include "tests/client/plot/state_map_messages.h"
#include "tests/client/plot/svg_elements.h"

namespace motiondb::tests::map_picture_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;

StateMap MapOf(const std::vector<v1::ReadStateMapResponse>& parts) {
  StateMap map;
  for (const auto& part : parts) REQUIRE(map.Add(part).ok());
  return map;
}

StateMap SmallMap() { return MapOf({MapHeader(), MapNodes(), MapTransitions(), MapPoints()}); }

const Bones kBones = {{0, 1}};

TEST_CASE("StateMap: collects the messages", "[client][cli]") {
  const StateMap map = SmallMap();
  CHECK(map.layer() == 3);
  CHECK(map.layer_count() == 3);
  CHECK(map.clips() == std::vector<std::string>{"07_01", "09_03"});
  REQUIRE(map.nodes().size() == 4);
  CHECK(map.nodes()[1].id == 5);
  CHECK(map.nodes()[1].mean == AxisVector{2, 0, 1});
  CHECK(map.nodes()[1].semi_axes[1][1] == Approx(0.2));
  CHECK(map.transitions().size() == 4);  // a node does not go to itself
  CHECK(map.points().size() == 3);
  CHECK(map.IndexOf(7) == 3);
  CHECK(map.IndexOf(8) == -1);
}

TEST_CASE("StateMap: messages that do not fit together are DATA_LOSS", "[client][cli]") {
  const auto refuses = [](v1::ReadStateMapResponse part, bool with_header = true) {
    StateMap map;
    if (with_header) REQUIRE(map.Add(MapHeader()).ok());
    CHECK(map.Add(part).code() == absl::StatusCode::kDataLoss);
  };
  refuses(MapHeader());
  refuses(MapNodes(), false);  // of unknown clips
  refuses(MapTransitions());   // of unknown nodes
  refuses(MapPoints(), false);
  auto nodes = MapNodes();
  nodes.mutable_nodes()->set_main_clips(0, 2);
  refuses(nodes);
  nodes = MapNodes();
  nodes.mutable_nodes()->mutable_means()->pop_back();
  refuses(nodes);
  nodes = MapNodes();
  nodes.mutable_nodes()->mutable_semi_axes()->clear();
  refuses(nodes);
  auto points = MapPoints();
  points.mutable_points()->set_clips(0, -1);
  refuses(points);
  auto header = MapHeader();
  header.mutable_header()->add_labels("more");
  refuses(header, false);
}

TEST_CASE("MapView: positions are the projected numbers", "[client][cli]") {
  const StateMap map = SmallMap();
  const PictureFrame frame{70, 80, 600, 400};
  for (const MapAxes& axes : {MapAxes{1, 2}, {1, 3}, {3, 2}}) {
    const MapView view(map, axes, frame);
    const auto component = [&](const AxisVector& p, int i) {
      return p[static_cast<std::size_t>(axes[static_cast<std::size_t>(i)] - 1)];
    };
    const AxisVector a = {-2, 0.5, 0}, b = {1.5, -1, 1};
    const Point at_a = view.At(a), at_b = view.At(b);
    // One scale: pixels are proportional to the differences, y upwards.
    const double scale = (at_b.x - at_a.x) / (component(b, 0) - component(a, 0));
    CHECK(scale > 0);
    CHECK(at_a.y - at_b.y == Approx(scale * (component(b, 1) - component(a, 1))));
    for (const MapNode& node : map.nodes()) {
      const EllipseShape outline = view.Outline(node.mean, node.semi_axes);
      CHECK(outline.centre.x == Approx(view.At(node.mean).x));
      const double half[] = {0.4, 0.2, 0.1};
      const double across = scale * half[axes[0] - 1], up = scale * half[axes[1] - 1];
      CHECK(outline.radius_x == Approx(std::max(across, up)).margin(1e-5));
      CHECK(outline.radius_y == Approx(std::min(across, up)).margin(1e-5));
      CHECK(std::abs(std::cos(outline.angle)) == Approx(across > up ? 1 : 0).margin(1e-5));
      CHECK(outline.centre.x - across > frame.left);
      CHECK(outline.centre.x + across < frame.right());
      CHECK(outline.centre.y - up > frame.top);
      CHECK(outline.centre.y + up < frame.bottom());
    }
  }
}

TEST_CASE("MapView: a rotated ellipsoid has a rotated outline", "[client][cli]") {
  const StateMap map = SmallMap();
  const MapView view(map, {1, 2}, {0, 0, 500, 500});
  const double scale = view.At({1, 0, 0}).x - view.At({0, 0, 0}).x;
  const double c = std::cos(0.6), s = std::sin(0.6);
  const EllipseShape outline =
      view.Outline({0, 0, 0}, {{{0.5 * c, 0.5 * s, 0}, {-0.2 * s, 0.2 * c, 0}, {0, 0, 9}}});
  CHECK(outline.radius_x == Approx(0.5 * scale));
  CHECK(outline.radius_y == Approx(0.2 * scale));
  CHECK(outline.angle == Approx(0.6));
}

TEST_CASE("MapPicture: points, transitions, nodes and poses at the ends of the axes",
          "[client][cli]") {
  const StateMap map = SmallMap();
  const auto extremes = ExtremeNodes(map, {1, 2});
  REQUIRE(extremes.size() == 4);
  CHECK(map.nodes()[static_cast<std::size_t>(extremes[0].node)].id == 4);
  CHECK(map.nodes()[static_cast<std::size_t>(extremes[1].node)].id == 5);
  CHECK(map.nodes()[static_cast<std::size_t>(extremes[2].node)].id == 6);
  CHECK(map.nodes()[static_cast<std::size_t>(extremes[3].node)].id == 7);
  const std::vector<MeanPose> poses(4, {TwoMarkerPose(0), {1, 0, 0, 0, 0, 1}});
  const std::string svg = SvgOf(MapPicture(map, "walks", {}, poses, kBones));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["circle.point a0"] == 1);  // jog
  CHECK(elements["circle.point a1"] == 2);  // walk
  CHECK(elements["line.thin"] == 4);
  CHECK(elements["circle.node"] == 4);
  CHECK(elements["circle.mark"] == 4);
  CHECK(Count(svg, "class=\"bone\"") == 4);
  CHECK(Count(svg, "class=\"marker\"") == 8);
  CHECK(Count(svg, "class=\"velocity\"") == 8);
  CHECK_THAT(svg, Contains("States of walks") && Contains(">A: node 4,<") &&
                      Contains(">lower end of axis 1<") &&
                      Contains("axis 1 (50 % of the variance)") &&
                      Contains("layer 3 of 3: 4 nodes, 4 transitions"));
  const std::string by_clip = SvgOf(
      MapPicture(map, "walks", {.axes = {1, 2, 3}, .colouring = MapColouring::kByClip}, {}, {}));
  CHECK_THAT(by_clip, Contains(">07_01<") && Contains("axis 3 (12 % of the variance) upwards<"));
  CHECK(ElementsInGroups(by_clip).count("circle.mark") == 0);
  CHECK(svg == SvgOf(MapPicture(map, "walks", {}, poses, kBones)));
}

TEST_CASE("LayerPicture: ellipses and edges as wide as probable", "[client][cli]") {
  const std::string svg = SvgOf(LayerPicture(SmallMap(), "walks", {}));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["ellipse.ellipse a1 c1"] == 2);
  CHECK(elements["ellipse.ellipse a0 c0"] == 2);
  CHECK(elements["line.transition"] == 4);
  CHECK(elements["polygon.arrow"] == 3);  // not of probability 0.01
  CHECK_THAT(svg,
             Contains("style=\"stroke-width:4.00\"><title>from node 5 to node 7: probability 1<") &&
                 Contains("style=\"stroke-width:1.30\"><title>from node 4 to node 6") &&
                 Contains("<title>node 7: 40 frames, 75 % jog</title>"));
}

TEST_CASE("ClipPicture: the nodes and transitions of the clip over all nodes", "[client][cli]") {
  auto nodes = MapNodes();
  v1::StateMapNodes& some = *nodes.mutable_nodes();
  for (auto* numbers : {some.mutable_node_ids(), some.mutable_parent_ids(),
                        some.mutable_frame_counts(), some.mutable_main_clips()}) {
    numbers->Truncate(2);
  }
  some.mutable_label_fractions()->Truncate(2);
  some.mutable_means()->resize(2 * 12);
  some.mutable_semi_axes()->resize(2 * 36);
  const StateMap clip = MapOf({MapHeader(), nodes});
  const std::string svg = SvgOf(ClipPicture(
      SmallMap(), clip, "07_01", {}, {{0, TwoMarkerPose(0)}, {1.5, TwoMarkerPose(3)}}, kBones));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["ellipse.ellipse a1 c1"] == 2);
  CHECK(elements["circle.other-node"] == 2);
  CHECK(elements.count("line.transition") == 0);
  CHECK(Count(svg, "class=\"bone\"") == 2);
  CHECK_THAT(svg, Contains("the clip visits 2 of 4 nodes of layer 3 of 3") && Contains(">1.50 s<"));
}

TEST_CASE("EstimatePicture: path, next nodes and predicted poses", "[client][cli]") {
  EstimatedMotion motion;
  motion.file = "a.bvh";
  motion.path = {4, 4, 6, 6, 99, 5};
  motion.prediction.set_at_seconds(1.25);
  for (const auto& [id, probability] : {std::pair{7, 0.64}, {99, 0.2}, {4, 0.04}}) {
    v1::NextNode& next = *motion.prediction.add_next_nodes();
    next.set_node_id(id);
    next.set_probability(probability);
  }
  for (const double seconds : {0.1, 0.5}) {
    v1::PredictedFrame& frame = *motion.prediction.add_horizons();
    frame.set_seconds(seconds);
    frame.set_marker_positions(Pack(TwoMarkerPose(static_cast<float>(seconds))));
    if (seconds < 0.3) frame.set_expected_error_m(0.034);
  }
  motion.prediction.mutable_horizons(1)->set_extrapolated(true);
  motion.next = {{TwoMarkerPose(0), {}}};
  motion.now = TwoMarkerPose(0);
  motion.then = {TwoMarkerPose(0.1F), {}};
  const std::string svg = SvgOf(EstimatePicture(SmallMap(), motion, "walks", {}, kBones));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["polyline.path"] == 1);
  CHECK(elements["circle.path-node"] == 2);
  CHECK(elements["circle.last-node"] == 1);
  CHECK(elements["circle.next-node"] == 2);  // 99 is not in the map
  CHECK(elements["line.next-line"] == 2);
  CHECK(elements["circle.other-node"] == 4);
  CHECK(Count(svg, "class=\"bone\"") == 4);  // next node, now, two horizons
  CHECK(Count(svg, "class=\"then-bone\"") == 1);
  CHECK_THAT(svg, Contains(">0.64<") && Contains(">expected error 3.4 cm<") &&
                      Contains(">extrapolated<") && Contains(">at 1.25 s<") &&
                      Contains(">probability 0.64<") && Contains("a.bvh in walks"));
}

TEST_CASE("Map pictures: hostile names, empty maps and wrong numbers are harmless",
          "[client][cli]") {
  const std::string hostile = "<script>alert(1)</script>";
  const StateMap named = MapOf({MapHeader(hostile), MapNodes(), MapPoints()});
  for (const Canvas& canvas :
       {MapPicture(named, hostile, {}, {}, {}), LayerPicture(named, hostile, {}),
        ClipPicture(named, named, hostile, {}, {}, {})}) {
    const std::string svg = SvgOf(canvas);
    ElementsInGroups(svg);
    CHECK_THAT(svg, !Contains("<script") && Contains("&lt;script&gt;"));
    CHECK(PngOf(canvas).ok());
  }
  const StateMap empty = MapOf({MapHeader()});
  CHECK(ExtremeNodes(empty, {1, 2}).empty());
  for (const MapAxes& axes : {MapAxes{1, 2}, {1, 2, 3}}) {
    CHECK(PngOf(MapPicture(empty, "walks", {.axes = axes}, {}, {})).ok());
    CHECK(PngOf(EstimatePicture(empty, {}, "walks", {.axes = axes}, {})).ok());
  }
  const float nan = std::numeric_limits<float>::quiet_NaN();
  auto nodes = MapNodes();
  nodes.mutable_nodes()->set_means(Pack(std::vector<float>(12, nan)));
  nodes.mutable_nodes()->set_semi_axes(Pack(std::vector<float>(36, 1e30F)));
  const StateMap wrong = MapOf({MapHeader(), nodes, MapTransitions()});
  const std::vector<MeanPose> poses(4, {{nan, 0, 0, 1e30F, 0, 0}, {nan, nan, nan, 0, 0, 0}});
  const Canvas canvas = MapPicture(wrong, "walks", {}, poses, kBones);
  CHECK_THAT(SvgOf(canvas), !Contains("nan\"") && !Contains("inf\""));
  CHECK(PngOf(canvas).ok());
  CHECK(PngOf(LayerPicture(wrong, "walks", {.axes = {1, 2, 3}})).ok());
}

TEST_CASE("MapColours: at most eight labels have colours", "[client][cli]") {
  auto header = MapHeader();
  for (int i = 0; i < 20; ++i) {
    header.mutable_header()->add_clips(fmt::format("databases/walks/clips/c{}", i));
    header.mutable_header()->add_labels(fmt::format("label {:02}", i));
  }
  const StateMap map = MapOf({header, MapNodes()});
  const MapColours colours(map, MapColouring::kByLabel);
  CHECK(colours.Legend().size() == 9);
  CHECK(colours.Legend().back().name == "14 other labels");
  CHECK(colours.FillStyle("07_01") == "a1");  // 30 of 100 frames
  CHECK(colours.FillStyle("09_03") == "a0");
  CHECK(colours.FillStyle("c19") == "others");
}

TEST_CASE("Poses: bones of missing markers are omitted", "[client][cli]") {
  v1::Figure figure = TwoMarkers();
  v1::Bone& wrong = *figure.add_marker_bones();
  wrong.set_from_point(-1);
  wrong.set_to_point(2);
  CHECK(MarkerBones(figure) == kBones);
  Canvas canvas;
  const Pose pose = {0, 0, 2, std::nanf(""), 0, 0};
  const PoseView view = ReferenceView({TwoMarkerPose(5), pose}, 100, 170);
  CHECK(view.pixels_per_m == Approx(100 * 170 / 200.0));
  DrawPose(canvas, pose, kBones, view, MiddleOf(pose), {50, 170}, {});
  REQUIRE(canvas.shapes().size() == 1);
  const auto& marker = std::get<CircleShape>(canvas.shapes()[0].geometry);
  CHECK(marker.centre.x == Approx(50));
  CHECK(marker.centre.y == Approx(0).margin(1e-9));
}

}  // namespace
}  // namespace motiondb::tests::map_picture_test
