#include "client/cli/picture/estimate_picture.h"

#include <fmt/format.h>
#include <motiondb/client.h>

#include <algorithm>
#include <cmath>

#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

double RadiusOf(double probability) { return 3 + 9 * std::sqrt(std::clamp(probability, 0.0, 1.0)); }

void AddEstimateStyles(Canvas& canvas) {
  canvas.AddStyle("path",
                  {.fill = "none", .stroke = "#e69f00", .stroke_width = 2.4, .round = true});
  canvas.AddStyle("path-node", {.fill = "#f0c040", .stroke = "#8a5f00", .stroke_width = 1});
  canvas.AddStyle("last-node", {.fill = "#f0c040", .stroke = "#222", .stroke_width = 2.4});
  canvas.AddStyle("next-node", {.fill = "#0072b2", .fill_opacity = 0.75});
  canvas.AddStyle("next-line", {.stroke = "#0072b2", .stroke_opacity = 0.75});
}

// The path without repetitions, as indices of the map.
std::vector<int> VisitedNodes(const StateMap& map, const std::vector<int>& path) {
  std::vector<int> visited;
  for (const int id : path) {
    const int node = map.IndexOf(id);
    if (node >= 0 && (visited.empty() || visited.back() != node)) visited.push_back(node);
  }
  return visited;
}

void DrawPathAndNext(Canvas& canvas, const StateMap& map, const MapView& view,
                     const EstimatedMotion& motion) {
  const auto at_node = [&](int node) {
    return view.At(map.nodes()[static_cast<std::size_t>(node)].mean);
  };
  const std::vector<int> visited = VisitedNodes(map, motion.path);
  std::vector<Point> points;
  std::transform(visited.begin(), visited.end(), std::back_inserter(points), at_node);
  if (!points.empty()) canvas.Polyline("path", points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    canvas.Circle(i + 1 < points.size() ? "path-node" : "last-node", points[i].x, points[i].y, 4.5)
        .tooltip = fmt::format("node {}", map.nodes()[static_cast<std::size_t>(visited[i])].id);
  }
  constexpr int kMaxNext = 12, kNamed = kNextPoses;
  int shown = 0;
  for (const v1::NextNode& next : motion.prediction.next_nodes()) {
    const int node = map.IndexOf(next.node_id());
    if (node < 0 || ++shown > kMaxNext) continue;
    const Point at = at_node(node);
    if (!points.empty()) {
      canvas.Line("next-line", points.back().x, points.back().y, at.x, at.y).stroke_width =
          0.5 + 3 * std::clamp(next.probability(), 0.0, 1.0);
    }
    canvas.Circle("next-node", at.x, at.y, RadiusOf(next.probability())).tooltip =
        fmt::format("next node {}: probability {:.3g}", next.node_id(), next.probability());
    if (shown <= kNamed) {
      canvas.Label("mark-text", at.x + RadiusOf(next.probability()) + 3, at.y + 4,
                   fmt::format("{:.2f}", next.probability()));
    }
  }
}

std::vector<CaptionedPose> PredictedPoses(const EstimatedMotion& motion) {
  std::vector<CaptionedPose> poses;
  if (!motion.now.empty()) {
    poses.push_back({{fmt::format("at {:.2f} s", motion.prediction.at_seconds()), "observed"},
                     motion.now,
                     {},
                     {}});
  }
  for (int i = 0; i < motion.prediction.horizons_size(); ++i) {
    const v1::PredictedFrame& frame = motion.prediction.horizons(i);
    const auto at = static_cast<std::size_t>(i);
    poses.push_back({{fmt::format("after {:.2f} s", frame.seconds()),
                      frame.has_expected_error_m()
                          ? fmt::format("expected error {:.1f} cm", 100 * frame.expected_error_m())
                      : frame.extrapolated() ? "extrapolated"
                                             : "error unknown"},
                     UnpackFloats(frame.marker_positions()),
                     {},
                     at < motion.then.size() ? motion.then[at] : Pose()});
  }
  return poses;
}

std::vector<CaptionedPose> NextPoses(const EstimatedMotion& motion) {
  std::vector<CaptionedPose> poses;
  const auto count = std::min<std::size_t>(
      motion.next.size(), static_cast<std::size_t>(motion.prediction.next_nodes_size()));
  for (std::size_t i = 0; i < count; ++i) {
    const v1::NextNode& next = motion.prediction.next_nodes(static_cast<int>(i));
    poses.push_back({{fmt::format("next node {}", next.node_id()),
                      fmt::format("probability {:.2f}", next.probability())},
                     motion.next[i].positions,
                     motion.next[i].velocities,
                     {}});
  }
  return poses;
}

}  // namespace

Canvas EstimatePicture(const StateMap& map, const EstimatedMotion& motion,
                       const std::string& database, const MapOptions& options, const Bones& bones) {
  MapPage page{
      .title = fmt::format("Estimate and prediction: {} in {}", TruncateToWidth(motion.file, 300),
                           database),
      .lines = {fmt::format("at {:.2f} s; path of {} in layer {} of {}",
                            motion.prediction.at_seconds(),
                            CountText(std::ssize(VisitedNodes(map, motion.path)), "node visit"),
                            map.layer(), map.layer_count()),
                "Below: predicted poses; grey: the motion at that time. Right: mean poses of the "
                "most probable next nodes."},
      .column = NextPoses(motion),
      .row = PredictedPoses(motion),
      .bones = bones};
  page.legend = {
      {"node path",
       [](Canvas& canvas, double x, double y) {
         canvas.Line("path", x, y, x + 20, y);
         canvas.Circle("path-node", x + 10, y, 4.5);
       }},
      {"last node",
       [](Canvas& canvas, double x, double y) { canvas.Circle("last-node", x + 10, y, 4.5); }},
      {"next nodes, larger if more probable",
       [](Canvas& canvas, double x, double y) { canvas.Circle("next-node", x + 10, y, 6); }},
      {"other nodes",
       [](Canvas& canvas, double x, double y) { canvas.Circle("other-node", x + 10, y, 2.4); }}};
  Canvas picture = MapPagePicture(map, options, page, [&](Canvas& canvas, const MapView& view) {
    for (const MapTransition& transition : map.transitions()) {
      const Point from = view.At(map.nodes()[static_cast<std::size_t>(transition.from)].mean);
      const Point to = view.At(map.nodes()[static_cast<std::size_t>(transition.to)].mean);
      canvas.Line("thin", from.x, from.y, to.x, to.y);
    }
    for (const MapNode& node : map.nodes()) {
      const Point at = view.At(node.mean);
      canvas.Circle("other-node", at.x, at.y, 2.4);
    }
    DrawPathAndNext(canvas, map, view, motion);
  });
  AddEstimateStyles(picture);
  return picture;
}

}  // namespace motiondb::client
