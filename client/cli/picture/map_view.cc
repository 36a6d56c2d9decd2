#include "client/cli/picture/map_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/cli/plot/recognition_plot_layout.h"
#include "client/cli/terminal/print.h"

namespace motiondb::client {

namespace {

// Of the oblique view: the second axis goes away from the reader.
constexpr Point kAwayDirection = {0.42, 0.28};

bool IsFinite(const AxisVector& position) {
  return std::all_of(position.begin(), position.end(), [](double x) { return std::isfinite(x); });
}

void Extend(const AxisVector& position, AxisVector& least, AxisVector& most) {
  if (!IsFinite(position)) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    least[axis] = std::min(least[axis], position[axis]);
    most[axis] = std::max(most[axis], position[axis]);
  }
}

}  // namespace

MapView::MapView(const StateMap& map, MapAxes axes, const PictureFrame& frame)
    : axes_(std::move(axes)), frame_(frame), directions_() {
  const auto index = [&](std::size_t i) { return static_cast<std::size_t>(axes_[i] - 1); };
  directions_[index(0)] = {1, 0};
  directions_[index(1)] = is_oblique() ? kAwayDirection : Point{0, 1};
  if (is_oblique()) directions_[index(2)] = {0, 1};
  for (const MapPoint& point : map.points()) Extend(point.position, least_, most_);
  for (const MapNode& node : map.nodes()) {
    for (const AxisVector& half : node.semi_axes) {
      for (const double sign : {-1.0, 1.0}) {
        AxisVector end = node.mean;
        for (std::size_t axis = 0; axis < 3; ++axis) end[axis] += sign * half[axis];
        Extend(end, least_, most_);
      }
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    AxisVector position;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = (corner >> axis & 1) != 0 ? most_[axis] : least_[axis];
    }
    const Point point = Projected(position);
    low_ = {std::min(low_.x, point.x), std::min(low_.y, point.y)};
    high_ = {std::max(high_.x, point.x), std::max(high_.y, point.y)};
  }
  constexpr double kBorder = 1.08;
  const double width = kBorder * std::max(high_.x - low_.x, 1e-6);
  const double height = kBorder * std::max(high_.y - low_.y, 1e-6);
  scale_ = std::min(frame.width / width, frame.height / height);
  const Point middle = {(low_.x + high_.x) / 2, (low_.y + high_.y) / 2};
  low_ = {middle.x - frame.width / scale_ / 2, middle.y - frame.height / scale_ / 2};
  high_ = {middle.x + frame.width / scale_ / 2, middle.y + frame.height / scale_ / 2};
}

Point MapView::Projected(const AxisVector& position) const {
  Point point;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    point.x += directions_[axis].x * position[axis];
    point.y += directions_[axis].y * position[axis];
  }
  return point;
}

Point MapView::At(const AxisVector& position) const {
  const Point point = Projected(position);
  return {frame_.left + scale_ * (point.x - low_.x), frame_.top + scale_ * (high_.y - point.y)};
}

EllipseShape MapView::Outline(const AxisVector& centre,
                              const std::array<AxisVector, 3>& semi_axes) const {
  // The outline is the ellipse of the projected covariance.
  double xx = 0, xy = 0, yy = 0;
  for (const AxisVector& half : semi_axes) {
    const Point point = Projected(half);
    xx += point.x * point.x;
    xy += point.x * point.y;
    yy += point.y * point.y;
  }
  const double mean = (xx + yy) / 2, difference = std::hypot((xx - yy) / 2, xy);
  return {At(centre), scale_ * std::sqrt(std::max(mean + difference, 0.0)),
          scale_ * std::sqrt(std::max(mean - difference, 0.0)), std::atan2(2 * xy, xx - yy) / 2};
}

void MapView::DrawAxes(Canvas& canvas, const StateMap& map) const {
  if (is_oblique()) return DrawObliqueAxes(canvas, map);
  const double step = TickStep(scale_);
  const std::vector<Tick> x_ticks = LinearTicks(
      low_.x, high_.x, step, [&](double x) { return frame_.left + scale_ * (x - low_.x); });
  const std::vector<Tick> y_ticks = LinearTicks(
      low_.y, high_.y, step, [&](double y) { return frame_.top + scale_ * (high_.y - y); });
  DrawGrid(canvas, frame_, x_ticks, y_ticks);
  DrawXTicks(canvas, frame_.bottom(), x_ticks);
  DrawYTicks(canvas, frame_, y_ticks);
  DrawXCaption(canvas, frame_, frame_.bottom(), AxisCaption(map, axes_[0]));
  DrawYCaption(canvas, frame_, AxisCaption(map, axes_[1]));
}

void MapView::DrawObliqueAxes(Canvas& canvas, const StateMap& map) const {
  constexpr int kMeshLines = 8;
  const auto index = [&](std::size_t i) { return static_cast<std::size_t>(axes_[i] - 1); };
  const auto on_axis = [&](std::size_t i, double value) {
    AxisVector position = {};
    position[index(i)] = value;
    return position;
  };
  for (const auto& [across, along] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 0}}) {
    for (int line = 0; line <= kMeshLines; ++line) {
      const double share = static_cast<double>(line) / kMeshLines;
      AxisVector from =
          on_axis(across, std::lerp(least_[index(across)], most_[index(across)], share));
      AxisVector to = from;
      from[index(along)] = least_[index(along)];
      to[index(along)] = most_[index(along)];
      const Point a = At(from), b = At(to);
      canvas.Line("grid", a.x, a.y, b.x, b.y);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Point from = At(on_axis(i, least_[index(i)])), to = At(on_axis(i, most_[index(i)]));
    canvas.Line("axis", from.x, from.y, to.x, to.y);
  }
  DrawXCaption(canvas, frame_, frame_.bottom() - 12,
               fmt::format("{} to the right, {} away, {} upwards", AxisCaption(map, axes_[0]),
                           AxisCaption(map, axes_[1]), AxisCaption(map, axes_[2])));
}

std::string AxisCaption(const StateMap& map, int axis) {
  const auto& fractions = map.variance_fractions();
  if (axis > static_cast<int>(fractions.size())) return fmt::format("axis {}", axis);
  return fmt::format("axis {} ({:.0f} % of the variance)", axis,
                     100 * fractions[static_cast<std::size_t>(axis - 1)]);
}

MapColours::MapColours(const StateMap& map, MapColouring colouring)
    : kind_(colouring == MapColouring::kByClip ? "other clip" : "other label") {
  constexpr int kMaxNames = 8;
  const auto& names = colouring == MapColouring::kByClip ? map.clips() : map.labels();
  std::map<std::string, PlotLabel> groups;
  for (const std::string& name : names) groups.try_emplace(name);
  for (const MapNode& node : map.nodes()) {
    groups[names[static_cast<std::size_t>(node.main_clip)]].probability += node.frame_count;
  }
  std::map<std::string, int> places;
  for (const PlotLabel& group : SortedLabels(groups)) {
    if (static_cast<int>(names_.size()) < kMaxNames) {
      places.emplace(group.name, static_cast<int>(names_.size()));
      names_.push_back(group.name);
    } else {
      ++other_count_;
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto place = places.find(names[i]);
    if (place != places.end()) place_of_clip_[map.clips()[i]] = place->second;
  }
}

std::string MapColours::FillStyle(const std::string& clip) const {
  const auto place = place_of_clip_.find(clip);
  return place == place_of_clip_.end() ? "others" : LabelAreaStyle(place->second);
}

std::string MapColours::LineStyle(const std::string& clip) const {
  const auto place = place_of_clip_.find(clip);
  return place == place_of_clip_.end() ? "others-line" : LabelLineStyle(place->second);
}

void MapColours::AddStyles(Canvas& canvas) {
  AddLabelStyles(canvas);
  canvas.AddStyle("others", {.fill = "#c4c4c4"});
  canvas.AddStyle("others-line", {.stroke = "#c4c4c4"});
}

std::vector<LegendEntry> MapColours::Legend() const {
  constexpr double kNameWidth = 190;
  const auto entry = [](const std::string& name, const std::string& style) {
    return LegendEntry{
        name, [style](Canvas& canvas, double x, double y) { canvas.Circle(style, x + 10, y, 5); }};
  };
  std::vector<LegendEntry> entries;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    entries.push_back(
        entry(TruncateToWidth(names_[i], kNameWidth), LabelAreaStyle(static_cast<int>(i))));
  }
  if (other_count_ > 0) entries.push_back(entry(CountText(other_count_, kind_), "others"));
  return entries;
}

}  // namespace motiondb::client
