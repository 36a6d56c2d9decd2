#include "client/cli/picture/map_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::client {

namespace {

constexpr double kPageLeft = 70, kPageRight = 26, kBelowAxes = 56, kLegendHeight = 22;
constexpr double kColumnWidth = 150, kRowHeight = 190, kCaptionHeight = 16, kPoseMargin = 8;
constexpr double kMinMapSize = 100;
constexpr double kTitleShare = 0.6;  // characters of titles are wider than those of lines

struct PageFrames {
  PictureFrame map, column, row;
  double legend_y = 0;
};

PageFrames FramesOf(const MapOptions& options, const MapPage& page) {
  const double right = options.width - kPageRight;
  Canvas scratch;
  const double legend = DrawLegend(scratch, page.legend, kPageLeft, right, 0) + kLegendHeight;
  PageFrames frames;
  const double top = HeadingHeight(page.lines.size());
  const double column = page.column.empty() ? 0 : kColumnWidth + kPageRight;
  const double row = page.row.empty() ? 0 : kRowHeight;
  frames.map = {kPageLeft, top, std::max(right - column - kPageLeft, kMinMapSize),
                std::max(options.height - top - kBelowAxes - row - legend, kMinMapSize)};
  frames.column = {frames.map.right() + kPageRight, top, kColumnWidth, frames.map.height};
  frames.row = {kPageLeft, frames.map.bottom() + kBelowAxes, right - kPageLeft, row};
  frames.legend_y = frames.row.bottom() + kLegendHeight / 2;
  return frames;
}

// Draws poses in cells of a frame, all at one scale.
class PoseCells {
 public:
  PoseCells(const MapPage& page, const std::vector<CaptionedPose>& poses, double width,
            double height)
      : page_(page), poses_(poses), width_(width), height_(height) {
    std::size_t lines = 0;
    for (const CaptionedPose& pose : poses) lines = std::max(lines, pose.caption.size());
    caption_ = kCaptionHeight * static_cast<double>(lines);
  }

  void Draw(Canvas& canvas, std::size_t index, double left, double top) const {
    const CaptionedPose& pose = poses_[index];
    const double foot = top + height_ - caption_ - kPoseMargin;
    const auto middle = MiddleOf(pose.positions);
    const Point at = {left + width_ / 2, foot};
    DrawPose(canvas, pose.then, page_.bones, view_, middle, at, {"then-bone", "then-marker", 1.8});
    DrawPose(canvas, pose.positions, page_.bones, view_, middle, at, {});
    DrawVelocities(canvas, pose.positions, pose.velocities, view_, middle, at);
    for (std::size_t i = 0; i < pose.caption.size(); ++i) {
      canvas.Label("pose-text", at.x,
                   foot + kPoseMargin + kCaptionHeight * (static_cast<double>(i) + 0.7),
                   TruncateToWidth(pose.caption[i], width_), Anchor::kMiddle);
    }
  }

  // `view_of`: ReferenceView or WidestView.
  void Fit(PoseView (*view_of)(const std::vector<Pose>&, double, double)) {
    std::vector<Pose> all;
    for (const CaptionedPose& pose : poses_) {
      all.push_back(pose.positions);
      if (!pose.then.empty()) all.push_back(pose.then);
    }
    view_ = view_of(all, width_ - 2 * kPoseMargin, height_ - caption_ - 2 * kPoseMargin);
  }

 private:
  const MapPage& page_;
  const std::vector<CaptionedPose>& poses_;
  const double width_, height_;
  double caption_ = 0;
  PoseView view_;
};

void DrawColumn(Canvas& canvas, const MapPage& page, const PictureFrame& frame) {
  if (page.column.empty()) return;
  const double height = frame.height / static_cast<double>(page.column.size());
  PoseCells cells(page, page.column, frame.width, height);
  cells.Fit(ReferenceView);
  for (std::size_t i = 0; i < page.column.size(); ++i) {
    cells.Draw(canvas, i, frame.left, frame.top + height * static_cast<double>(i));
  }
}

void DrawRow(Canvas& canvas, const MapPage& page, const PictureFrame& frame) {
  if (page.row.empty()) return;
  const double width = frame.width / static_cast<double>(page.row.size());
  PoseCells cells(page, page.row, width, frame.height);
  cells.Fit(WidestView);
  for (std::size_t i = 0; i < page.row.size(); ++i) {
    cells.Draw(canvas, i, frame.left + width * static_cast<double>(i), frame.top);
  }
}

void AddMapStyles(Canvas& canvas) {
  canvas.AddStyle("axis", {.stroke = "#888", .stroke_width = 1.2});
  canvas.AddStyle("transition", {.stroke = "#555", .stroke_opacity = 0.5});
  canvas.AddStyle("arrow", {.fill = "#333", .fill_opacity = 0.7});
  canvas.AddStyle("thin", {.stroke = "#666", .stroke_width = 0.6, .stroke_opacity = 0.35});
  canvas.AddStyle("point", {.fill_opacity = 0.6});
  canvas.AddStyle("node", {.fill = "#fff", .stroke = "#333", .stroke_width = 0.8});
  canvas.AddStyle("other-node", {.fill = "#ccc"});
  canvas.AddStyle("ellipse", {.fill_opacity = 0.35, .stroke_width = 1.2});
  canvas.AddStyle("mark", {.fill = "none", .stroke = "#222", .stroke_width = 1.6});
  canvas.AddStyle("mark-text", {.fill = "#222", .font_size = 13, .bold = true});
}

}  // namespace

Canvas MapPagePicture(const StateMap& map, const MapOptions& options, const MapPage& page,
                      const std::function<void(Canvas& canvas, const MapView& view)>& draw_map) {
  const PageFrames frames = FramesOf(options, page);
  const MapView view(map, options.axes, frames.map);
  Canvas canvas;
  MapColours::AddStyles(canvas);
  AddMapStyles(canvas);
  AddPoseStyles(canvas);
  canvas.SetTitle(page.title);
  canvas.SetSize(options.width, options.height);
  const double width = options.width - kPageLeft - kPageRight;
  DrawHeading(canvas, kPageLeft, width, TruncateToWidth(page.title, kTitleShare * width),
              page.lines);
  view.DrawAxes(canvas, map);
  canvas.BeginGroup(frames.map);
  draw_map(canvas, view);
  canvas.EndGroup();
  canvas.Rectangle("frame", frames.map);
  DrawColumn(canvas, page, frames.column);
  DrawRow(canvas, page, frames.row);
  DrawLegend(canvas, page.legend, kPageLeft, options.width - kPageRight, frames.legend_y);
  return canvas;
}

namespace {

double WidthOf(double probability) { return 0.4 + 3.6 * std::clamp(probability, 0.0, 1.0); }

// A triangle a bit after the middle of a line.
void DrawArrow(Canvas& canvas, Point from, Point to, double size) {
  constexpr double kAt = 0.6;
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (!(length > 3 * size)) return;
  const Point along = {(to.x - from.x) / length, (to.y - from.y) / length};
  const Point tip = {std::lerp(from.x, to.x, kAt) + size * along.x,
                     std::lerp(from.y, to.y, kAt) + size * along.y};
  const auto corner = [&](double side) {
    return Point{tip.x - 2 * size * along.x - side * size * along.y,
                 tip.y - 2 * size * along.y + side * size * along.x};
  };
  canvas.Polygon("arrow", {tip, corner(1), corner(-1)});
}

}  // namespace

void DrawTransitions(Canvas& canvas, const StateMap& map, const MapView& view) {
  constexpr std::size_t kMaxTransitions = 5000;
  constexpr double kMinArrow = 0.05;  // probability
  std::vector<MapTransition> shown = map.transitions();
  std::stable_sort(shown.begin(), shown.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  shown.resize(std::min(shown.size(), kMaxTransitions));
  for (const MapTransition& transition : shown) {
    const MapNode& from_node = map.nodes()[static_cast<std::size_t>(transition.from)];
    const MapNode& to_node = map.nodes()[static_cast<std::size_t>(transition.to)];
    const Point from = view.At(from_node.mean), to = view.At(to_node.mean);
    Shape& line = canvas.Line("transition", from.x, from.y, to.x, to.y);
    line.stroke_width = WidthOf(transition.probability);
    line.tooltip = fmt::format("from node {} to node {}: probability {:.3g}", from_node.id,
                               to_node.id, transition.probability);
    if (transition.probability >= kMinArrow) {
      DrawArrow(canvas, from, to, 2 + WidthOf(transition.probability) / 2);
    }
  }
}

std::vector<LegendEntry> TransitionLegend() {
  std::vector<LegendEntry> entries;
  for (const double probability : {0.1, 0.5, 1.0}) {
    entries.push_back({fmt::format("transition with probability {:g}", probability),
                       [probability](Canvas& canvas, double x, double y) {
                         canvas.Line("transition", x, y, x + 20, y).stroke_width =
                             WidthOf(probability);
                       }});
  }
  return entries;
}

void DrawNodes(Canvas& canvas, const StateMap& map, const MapView& view,
               const MapColours& colours) {
  for (const MapNode& node : map.nodes()) {
    const std::string& clip = map.clips()[static_cast<std::size_t>(node.main_clip)];
    canvas
        .Ellipse(fmt::format("ellipse {} {}", colours.FillStyle(clip), colours.LineStyle(clip)),
                 view.Outline(node.mean, node.semi_axes))
        .tooltip = fmt::format("node {}: {} frames, {:.0f} % {}", node.id, node.frame_count,
                               100 * node.label_fraction,
                               map.labels()[static_cast<std::size_t>(node.main_clip)]);
  }
}

}  // namespace motiondb::client
