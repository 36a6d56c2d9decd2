#include "client/cli/picture/pose_drawing.h"

#include <motiondb/v1/view.pb.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace motiondb::client {

namespace {

constexpr double kMaxM = 1e4;  // of a coordinate; markers outside are not drawn

int MarkerCount(const Pose& pose) { return static_cast<int>(pose.size() / 3); }

// Calls `use(marker, x, y, z)` for each marker that is not missing.
template <typename Use>
void ForMarkers(const Pose& pose, const Use& use) {
  for (int i = 0; i < MarkerCount(pose); ++i) {
    const float* position = pose.data() + 3 * i;
    const bool known = std::all_of(position, position + 3, [](float value) {
      return std::isfinite(value) && std::abs(value) <= kMaxM;
    });
    if (known) use(i, position[0], position[1], position[2]);
  }
}

PoseView FittingView(const std::vector<Pose>& poses, double right_x, double right_y, double width,
                     double height) {
  double low = std::numeric_limits<double>::infinity(), high = -low, half_width = 0;
  for (const Pose& pose : poses) {
    const auto [middle_x, middle_y] = MiddleOf(pose);
    ForMarkers(pose, [&, mx = middle_x, my = middle_y](int, double x, double y, double z) {
      low = std::min(low, z);
      high = std::max(high, z);
      half_width = std::max(half_width, std::abs(right_x * (x - mx) + right_y * (y - my)));
    });
  }
  PoseView view{right_x, right_y, 0, 1};
  if (!(low <= high)) return view;
  view.low_z = low;
  view.pixels_per_m =
      std::min(height / std::max(high - low, 0.1), width / 2 / std::max(half_width, 0.05));
  return view;
}

}  // namespace

Bones MarkerBones(const v1::Figure& figure) {
  Bones bones;
  const int count = figure.marker_names_size();
  for (const v1::Bone& bone : figure.marker_bones()) {
    const int from = bone.from_point(), to = bone.to_point();
    if (std::min(from, to) >= 0 && std::max(from, to) < count) bones.emplace_back(from, to);
  }
  return bones;
}

PoseView ReferenceView(const std::vector<Pose>& poses, double width, double height) {
  return FittingView(poses, -std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, width, height);
}

PoseView WidestView(const std::vector<Pose>& poses, double width, double height) {
  double xx = 0, xy = 0, yy = 0;
  for (const Pose& pose : poses) {
    const auto [middle_x, middle_y] = MiddleOf(pose);
    ForMarkers(pose, [&, mx = middle_x, my = middle_y](int, double x, double y, double) {
      xx += (x - mx) * (x - mx);
      xy += (x - mx) * (y - my);
      yy += (y - my) * (y - my);
    });
  }
  const double angle = std::atan2(2 * xy, xx - yy) / 2;
  return FittingView(poses, std::cos(angle), std::sin(angle), width, height);
}

std::pair<double, double> MiddleOf(const Pose& pose) {
  double sum_x = 0, sum_y = 0;
  int count = 0;
  ForMarkers(pose, [&](int, double x, double y, double) {
    sum_x += x;
    sum_y += y;
    ++count;
  });
  return {sum_x / std::max(count, 1), sum_y / std::max(count, 1)};
}

namespace {

Point InView(const PoseView& view, std::pair<double, double> middle, Point foot, double x, double y,
             double z) {
  const double across = view.right_x * (x - middle.first) + view.right_y * (y - middle.second);
  return {foot.x + view.pixels_per_m * across, foot.y - view.pixels_per_m * (z - view.low_z)};
}

}  // namespace

void DrawPose(Canvas& canvas, const Pose& pose, const Bones& bones, const PoseView& view,
              std::pair<double, double> middle, Point foot, const PoseStyle& style) {
  std::vector<Point> points(static_cast<std::size_t>(MarkerCount(pose)));
  std::vector<bool> known(points.size());
  ForMarkers(pose, [&](int marker, double x, double y, double z) {
    const auto at = static_cast<std::size_t>(marker);
    points[at] = InView(view, middle, foot, x, y, z);
    known[at] = true;
  });
  for (const auto& [from, to] : bones) {
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    if (std::max(a, b) >= points.size() || !known[a] || !known[b]) continue;
    canvas.Line(style.bone, points[a].x, points[a].y, points[b].x, points[b].y);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (known[i]) canvas.Circle(style.marker, points[i].x, points[i].y, style.marker_radius);
  }
}

void DrawVelocities(Canvas& canvas, const Pose& pose, const Pose& velocities, const PoseView& view,
                    std::pair<double, double> middle, Point foot) {
  constexpr double kSeconds = 0.1;
  if (velocities.size() != pose.size()) return;
  ForMarkers(pose, [&](int marker, double x, double y, double z) {
    const float* velocity = velocities.data() + 3 * marker;
    const Point from = InView(view, middle, foot, x, y, z);
    const Point to = InView(view, middle, foot, x + kSeconds * velocity[0],
                            y + kSeconds * velocity[1], z + kSeconds * velocity[2]);
    canvas.Line("velocity", from.x, from.y, to.x, to.y);
  });
}

void AddPoseStyles(Canvas& canvas) {
  canvas.AddStyle("bone", {.stroke = "#888", .stroke_width = 1.4, .round = true});
  canvas.AddStyle("marker", {.fill = "#0072b2"});
  canvas.AddStyle("velocity", {.stroke = "#d55e00", .stroke_width = 1.2, .round = true});
  canvas.AddStyle("then-bone", {.stroke = "#d0d0d0", .stroke_width = 1.4, .round = true});
  canvas.AddStyle("then-marker", {.fill = "#b0b0b0"});
  canvas.AddStyle("ghost-bone", {.stroke = "#56b4e9", .stroke_width = 1.4, .round = true});
  canvas.AddStyle("pose-text", {.fill = "#444", .font_size = 12});
}

}  // namespace motiondb::client
