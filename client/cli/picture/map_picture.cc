#include "client/cli/picture/map_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

std::string LayerText(const StateMap& map) {
  return fmt::format("layer {} of {}: {}, {} between different nodes", map.layer(),
                     map.layer_count(), CountText(std::ssize(map.nodes()), "node"),
                     CountText(std::ssize(map.transitions()), "transition"));
}

constexpr char kScale[] = "Principal axes of all states, in scaled units; 0 is the mean.";

char LetterOf(std::size_t index) { return static_cast<char>('A' + index); }

void DrawExtremeNodes(Canvas& canvas, const StateMap& map, const MapView& view,
                      const std::vector<ExtremeNode>& extremes) {
  for (std::size_t i = 0; i < extremes.size(); ++i) {
    const Point at = view.At(map.nodes()[static_cast<std::size_t>(extremes[i].node)].mean);
    canvas.Circle("mark", at.x, at.y, 6);
    // Inside the frame.
    const double side = extremes[i].is_high && i < 2 ? -1 : 1;
    canvas.Label("mark-text", at.x + 10 * side, at.y - 8, std::string(1, LetterOf(i)),
                 side < 0 ? Anchor::kEnd : Anchor::kStart);
  }
}

}  // namespace

std::vector<ExtremeNode> ExtremeNodes(const StateMap& map, const MapAxes& axes) {
  std::vector<ExtremeNode> extremes;
  if (map.nodes().empty()) return extremes;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto axis = static_cast<std::size_t>(axes[i] - 1);
    const auto [low, high] = std::minmax_element(
        map.nodes().begin(), map.nodes().end(),
        [axis](const MapNode& a, const MapNode& b) { return a.mean[axis] < b.mean[axis]; });
    for (const auto& [node, is_high] : {std::pair(low, false), {high, true}}) {
      extremes.push_back({axes[i], is_high, static_cast<int>(node - map.nodes().begin())});
    }
  }
  return extremes;
}

Canvas MapPicture(const StateMap& map, const std::string& database, const MapOptions& options,
                  const std::vector<MeanPose>& poses, const Bones& bones) {
  const MapColours colours(map, options.colouring);
  std::vector<ExtremeNode> extremes = ExtremeNodes(map, options.axes);
  extremes.resize(std::min(extremes.size(), poses.size()));
  MapPage page{
      .title = "States of " + database,
      .lines = {fmt::format("{}, and {} as points; {}", CountText(std::ssize(map.clips()), "clip"),
                            CountText(std::ssize(map.points()), "frame"), LayerText(map)),
                kScale},
      .legend = colours.Legend(),
      .bones = bones};
  for (std::size_t i = 0; i < extremes.size(); ++i) {
    const ExtremeNode& extreme = extremes[i];
    const MapNode& node = map.nodes()[static_cast<std::size_t>(extreme.node)];
    page.column.push_back(
        {{fmt::format("{}: node {},", LetterOf(i), node.id),
          fmt::format("{} end of axis {}", extreme.is_high ? "upper" : "lower", extreme.axis)},
         poses[i].positions,
         poses[i].velocities,
         {}});
  }
  page.legend.push_back(
      {"node", [](Canvas& canvas, double x, double y) { canvas.Circle("node", x + 10, y, 3); }});
  page.legend.push_back({"transition", [](Canvas& canvas, double x, double y) {
                           canvas.Line("thin", x, y, x + 20, y);
                         }});
  return MapPagePicture(map, options, page, [&](Canvas& canvas, const MapView& view) {
    for (const MapPoint& point : map.points()) {
      const Point at = view.At(point.position);
      canvas.Circle("point " + colours.FillStyle(map.clips()[static_cast<std::size_t>(point.clip)]),
                    at.x, at.y, 1.6);
    }
    for (const MapTransition& transition : map.transitions()) {
      const Point from = view.At(map.nodes()[static_cast<std::size_t>(transition.from)].mean);
      const Point to = view.At(map.nodes()[static_cast<std::size_t>(transition.to)].mean);
      canvas.Line("thin", from.x, from.y, to.x, to.y);
    }
    for (const MapNode& node : map.nodes()) {
      const Point at = view.At(node.mean);
      canvas.Circle("node", at.x, at.y, 2.4).tooltip =
          fmt::format("node {}: {} frames", node.id, node.frame_count);
    }
    DrawExtremeNodes(canvas, map, view, extremes);
  });
}

Canvas LayerPicture(const StateMap& map, const std::string& database, const MapOptions& options) {
  const MapColours colours(map, options.colouring);
  MapPage page{
      .title = fmt::format("Nodes and transitions of {}", database),
      .lines = {LayerText(map), fmt::format("{} Ellipses: one standard deviation.", kScale)},
      .legend = colours.Legend()};
  for (LegendEntry& entry : TransitionLegend()) page.legend.push_back(std::move(entry));
  return MapPagePicture(map, options, page, [&](Canvas& canvas, const MapView& view) {
    DrawTransitions(canvas, map, view);
    DrawNodes(canvas, map, view, colours);
  });
}

Canvas ClipPicture(const StateMap& map, const StateMap& clip_map, const std::string& clip,
                   const MapOptions& options, const std::vector<ClipMoment>& moments,
                   const Bones& bones) {
  const MapColours colours(map, options.colouring);
  MapPage page{.title = "Transition graph of clip " + clip,
               .lines = {fmt::format("the clip visits {} of {} nodes of layer {} of {}",
                                     clip_map.nodes().size(), map.nodes().size(), map.layer(),
                                     map.layer_count()),
                         fmt::format("{} Ellipses: one standard deviation.", kScale)},
               .legend = colours.Legend(),
               .bones = bones};
  for (LegendEntry& entry : TransitionLegend()) page.legend.push_back(std::move(entry));
  page.legend.push_back({"node of other clips", [](Canvas& canvas, double x, double y) {
                           canvas.Circle("other-node", x + 10, y, 2.4);
                         }});
  for (const ClipMoment& moment : moments) {
    page.row.push_back({{fmt::format("{:.2f} s", moment.seconds)}, moment.positions, {}, {}});
  }
  return MapPagePicture(map, options, page, [&](Canvas& canvas, const MapView& view) {
    for (const MapNode& node : map.nodes()) {
      const Point at = view.At(node.mean);
      if (clip_map.IndexOf(node.id) < 0) canvas.Circle("other-node", at.x, at.y, 2.4);
    }
    DrawTransitions(canvas, clip_map, view);
    DrawNodes(canvas, clip_map, view, colours);
  });
}

}  // namespace motiondb::client
