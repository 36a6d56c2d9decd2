#include "client/cli/plot/floor_plan.h"

#include <fmt/format.h>
#include <motiondb/v1/plan.pb.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/plan_text.h"
#include "client/cli/plot/picture.h"

namespace motiondb::client {

namespace {

constexpr double kBorder = 0.06;     // margin, as a share of the larger extent
constexpr double kMinExtentM = 0.5;  // if nothing moves

// Widens [low, high] symmetrically to at least `extent`.
void Widen(double extent, double& low, double& high) {
  const double missing = extent - (high - low);
  if (missing <= 0) return;
  low -= missing / 2;
  high += missing / 2;
}

}  // namespace

void FloorBounds::Add(double x, double y, double radius) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(radius)) return;
  min_x = std::min(min_x, x - radius);
  max_x = std::max(max_x, x + radius);
  min_y = std::min(min_y, y - radius);
  max_y = std::max(max_y, y + radius);
}

FloorView::FloorView(const FloorBounds& bounds, double left, double top, const Limits& limits)
    : bounds_(bounds) {
  const double border = kBorder * std::max({bounds.width(), bounds.height(), kMinExtentM});
  Widen(std::max(bounds.width(), kMinExtentM) + 2 * border, bounds_.min_x, bounds_.max_x);
  Widen(std::max(bounds.height(), kMinExtentM) + 2 * border, bounds_.min_y, bounds_.max_y);
  pixels_per_m_ =
      std::min(limits.max_width / bounds_.width(), limits.max_height / bounds_.height());
  Widen(limits.min_width / pixels_per_m_, bounds_.min_x, bounds_.max_x);
  Widen(limits.min_height / pixels_per_m_, bounds_.min_y, bounds_.max_y);
  frame_ = {left, top, Pixels(bounds_.width()), Pixels(bounds_.height())};
}

namespace {

constexpr double kLeft = 70, kRight = 26, kBottom = 96;  // margins of the floor (pixels)
constexpr double kPosesPerSecond = 6;
constexpr double kPoseRadius = 3.4, kHeadingLength = 15;
constexpr double kWedgeRadius = 46;

void AddFloorStyles(Canvas& canvas) {
  canvas.AddStyle("clearance-edge", {.fill = "#d9a066", .stroke = "#d9a066", .round = true});
  canvas.AddStyle("clearance", {.fill = "#fbeedd", .stroke = "#fbeedd", .round = true});
  canvas.AddStyle("obstacle", {.fill = "#b9834f", .stroke = "#7d5427", .stroke_width = 1});
  canvas.AddStyle("tolerance", {.fill = "#d62728",
                                .fill_opacity = 0.10,
                                .stroke = "#d62728",
                                .stroke_width = 1.2,
                                .dashes = {4, 3}});
  canvas.AddStyle("wedge", {.fill = "#d62728", .fill_opacity = 0.22});
  canvas.AddStyle("goal", {.fill = "none", .stroke = "#d62728", .stroke_width = 2, .round = true});
  canvas.AddStyle("start", {.fill = "#222", .stroke = "#222", .stroke_width = 2, .round = true});
  canvas.AddStyle("path",
                  {.fill = "none", .stroke = "#1f5fbf", .stroke_width = 1.4, .round = true});
  canvas.AddStyle("pose", {.fill = "#fff", .stroke = "#1f5fbf", .stroke_width = 1.4});
  canvas.AddStyle("end", {.fill = "#1f5fbf", .stroke = "#1f5fbf", .stroke_width = 1.4});
  canvas.AddStyle("heading", {.stroke = "#2a9d4a", .stroke_width = 1.8, .round = true});
  canvas.AddStyle("other",
                  {.fill = "none", .stroke = "#b4c7e3", .stroke_width = 1.4, .round = true});
  canvas.AddStyle("other-pose", {.fill = "#fff", .stroke = "#b4c7e3", .stroke_width = 1});
  canvas.AddStyle("other-heading", {.stroke = "#b9dfc4", .stroke_width = 1.4, .round = true});
}

// A line of `length` pixels from a point in a direction. The picture's y axis points down.
void DrawRay(Canvas& canvas, const char* style, double x, double y, double heading, double length) {
  canvas.Line(style, x, y, x + length * std::cos(heading), y - length * std::sin(heading));
}

// ---- The floor ----------------------------------------------------------------------------------

double Clearance(const v1::PlanRequest& request) {
  constexpr double kDefault = 0.3;  // from the wire contract
  return request.obstacles().has_clearance_m() ? request.obstacles().clearance_m() : kDefault;
}

double PositionTolerance(const v1::PlanRequest& request) {
  constexpr double kDefault = 0.1;
  return request.has_position_tolerance_m() ? request.position_tolerance_m() : kDefault;
}

double HeadingTolerance(const v1::PlanRequest& request) {
  constexpr double kDefault = 0.1;
  return request.has_heading_tolerance_rad() ? request.heading_tolerance_rad() : kDefault;
}

void AddPath(const v1::PlannedMotion& motion, FloorBounds& bounds) {
  for (const v1::FloorPose& pose : motion.root()) bounds.Add(pose.x_m(), pose.y_m());
}

// Bounds of start, goal and paths, and of obstacles near them.
FloorBounds BoundsOf(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  FloorBounds bounds;  // contains the start, the origin
  bounds.Add(request.goal().x_m(), request.goal().y_m(), PositionTolerance(request));
  AddPath(response.motion(), bounds);
  for (const v1::PlannedMotion& motion : response.alternatives()) AddPath(motion, bounds);
  const double reach = std::max({bounds.width(), bounds.height(), 1.0});
  const FloorBounds near{bounds.min_x - reach, bounds.max_x + reach, bounds.min_y - reach,
                         bounds.max_y + reach};
  const auto add_near = [&](double x, double y) {
    bounds.Add(std::clamp(x, near.min_x, near.max_x), std::clamp(y, near.min_y, near.max_y));
  };
  const double clearance = Clearance(request);
  for (const v1::Disc& disc : request.obstacles().discs()) {
    const double radius = disc.radius_m() + clearance;
    add_near(disc.centre().x_m() - radius, disc.centre().y_m() - radius);
    add_near(disc.centre().x_m() + radius, disc.centre().y_m() + radius);
  }
  for (const v1::Polygon& polygon : request.obstacles().polygons()) {
    for (const v1::FloorPoint& corner : polygon.corners()) {
      add_near(corner.x_m() - clearance, corner.y_m() - clearance);
      add_near(corner.x_m() + clearance, corner.y_m() + clearance);
    }
  }
  return bounds;
}

// All obstacles, each grown by `margin` pixels.
void DrawGrown(Canvas& canvas, const v1::Obstacles& obstacles, const FloorView& view,
               const char* style, double margin) {
  for (const v1::Disc& disc : obstacles.discs()) {
    canvas.Circle(style, view.X(disc.centre().x_m()), view.Y(disc.centre().y_m()),
                  view.Pixels(disc.radius_m()) + margin);
  }
  for (const v1::Polygon& polygon : obstacles.polygons()) {
    std::vector<Point> corners;
    for (const v1::FloorPoint& corner : polygon.corners()) {
      corners.push_back({view.X(corner.x_m()), view.Y(corner.y_m())});
    }
    Shape& shape = canvas.Polygon(style, std::move(corners));
    // A wide outline with round corners covers the margin.
    if (margin > 0) shape.stroke_width = 2 * margin;
  }
}

// Draws all edges first and all insides over them, so that overlapping clearances have one outline.
void DrawObstacles(Canvas& canvas, const v1::PlanRequest& request, const FloorView& view) {
  const double clearance = view.Pixels(Clearance(request));
  const v1::Obstacles& obstacles = request.obstacles();
  if (clearance > 0) {
    DrawGrown(canvas, obstacles, view, "clearance-edge", clearance + 1);
    DrawGrown(canvas, obstacles, view, "clearance", clearance);
  }
  DrawGrown(canvas, obstacles, view, "obstacle", 0);
}

void DrawWedge(Canvas& canvas, double x, double y, double heading, double half_angle) {
  if (half_angle >= std::numbers::pi) {
    canvas.Circle("wedge", x, y, kWedgeRadius);
  } else {
    canvas.Sector("wedge", {{x, y}, kWedgeRadius, heading - half_angle, heading + half_angle});
  }
}

void DrawGoalMark(Canvas& canvas, double x, double y, double heading) {
  constexpr double kArm = 5;
  canvas.Line("goal", x - kArm, y - kArm, x + kArm, y + kArm);
  canvas.Line("goal", x - kArm, y + kArm, x + kArm, y - kArm);
  DrawRay(canvas, "goal", x, y, heading, kWedgeRadius);
}

void DrawGoal(Canvas& canvas, const v1::PlanRequest& request, const FloorView& view) {
  const double x = view.X(request.goal().x_m());
  const double y = view.Y(request.goal().y_m());
  const double heading = request.goal().heading_rad();
  canvas.Circle("tolerance", x, y, view.Pixels(PositionTolerance(request)));
  DrawWedge(canvas, x, y, heading, HeadingTolerance(request));
  DrawGoalMark(canvas, x, y, heading);
}

void DrawStartMark(Canvas& canvas, double x, double y) {
  DrawRay(canvas, "start", x, y, 0, 16);
  canvas.Circle("start", x, y, 4.5);
}

struct PathStyle {
  const char* path;
  const char* pose;
  const char* heading;
};

void DrawPath(Canvas& canvas, const v1::PlannedMotion& motion, const FloorView& view,
              const PathStyle& style) {
  constexpr double kMinStep = 0.75;  // pixels; closer points are omitted
  std::vector<Point> points;
  for (int i = 0; i < motion.root_size(); ++i) {
    const Point point = {view.X(motion.root(i).x_m()), view.Y(motion.root(i).y_m())};
    const bool end = i == 0 || i == motion.root_size() - 1;
    if (!end && std::hypot(point.x - points.back().x, point.y - points.back().y) < kMinStep) {
      continue;
    }
    points.push_back(point);
  }
  if (!points.empty()) canvas.Polyline(style.path, std::move(points));
  const double step = motion.frame_rate_hz() / kPosesPerSecond;
  if (!(step > 0)) return;
  std::vector<Point> poses;
  int last_frame = -1;
  for (int i = 0;; ++i) {
    const double exact = std::round(i * step);
    if (exact >= motion.root_size()) break;
    const int frame = static_cast<int>(exact);
    if (frame == last_frame) continue;
    last_frame = frame;
    const v1::FloorPose& pose = motion.root(frame);
    poses.push_back({view.X(pose.x_m()), view.Y(pose.y_m())});
    DrawRay(canvas, style.heading, poses.back().x, poses.back().y, pose.heading_rad(),
            kHeadingLength);
  }
  for (const Point& pose : poses) canvas.Circle(style.pose, pose.x, pose.y, kPoseRadius);
}

void DrawEnd(Canvas& canvas, const v1::PlannedMotion& motion, const FloorView& view) {
  if (motion.root_size() == 0) return;
  const v1::FloorPose& end = motion.root(motion.root_size() - 1);
  const double x = view.X(end.x_m());
  const double y = view.Y(end.y_m());
  DrawRay(canvas, "heading", x, y, end.heading_rad(), kHeadingLength);
  canvas.Circle("end", x, y, kPoseRadius);
}

// ---- Axes, legend, heading ----------------------------------------------------------------------

void DrawAxes(Canvas& canvas, const FloorView& view) {
  const PictureFrame& frame = view.frame();
  const FloorBounds& bounds = view.bounds();
  const double step = view.TickStep();
  const std::vector<Tick> x_ticks =
      LinearTicks(bounds.min_x, bounds.max_x, step, [&](double x) { return view.X(x); });
  const std::vector<Tick> y_ticks =
      LinearTicks(bounds.min_y, bounds.max_y, step, [&](double y) { return view.Y(y); });
  DrawGrid(canvas, frame, x_ticks, y_ticks);
  DrawXTicks(canvas, frame.bottom(), x_ticks);
  DrawYTicks(canvas, frame, y_ticks);
  DrawXCaption(canvas, frame, frame.bottom(), "to the front: x (m)");
  DrawYCaption(canvas, frame, "to the left: y (m)");
}

void DrawFloorLegend(Canvas& canvas, const v1::PlanRequest& request,
                     const v1::PlanResponse& response, const FloorView& view) {
  std::vector<LegendEntry> entries;
  entries.push_back({"start", DrawStartMark});
  entries.push_back({"goal and tolerance", [](Canvas& picture, double x, double y) {
                       picture.Circle("tolerance", x + 4, y, 8);
                       picture.Circle("goal", x + 4, y, 1);
                     }});
  if (response.has_motion()) {
    entries.push_back({"root and heading, every 1/6 s", [](Canvas& picture, double x, double y) {
                         picture.Line("path", x - 8, y, x + 16, y);
                         DrawRay(picture, "heading", x, y, 0.8, kHeadingLength);
                         picture.Circle("pose", x, y, kPoseRadius);
                       }});
  }
  if (response.alternatives_size() > 0) {
    entries.push_back({"alternatives", [](Canvas& picture, double x, double y) {
                         picture.Line("other", x - 8, y, x + 16, y);
                         picture.Circle("other-pose", x + 4, y, kPoseRadius);
                       }});
  }
  if (request.obstacles().discs_size() + request.obstacles().polygons_size() > 0) {
    entries.push_back({"obstacle and clearance", [](Canvas& picture, double x, double y) {
                         picture.Circle("clearance-edge", x + 4, y, 9);
                         picture.Circle("clearance", x + 4, y, 8);
                         picture.Circle("obstacle", x + 4, y, 4);
                       }});
  }
  const PictureFrame& frame = view.frame();
  DrawLegend(canvas, entries, frame.left + 8, frame.right() + kRight, frame.bottom() + 62);
}

// Returns the lines below the title.
std::vector<std::string> LinesBelowTitle(const v1::PlanResponse& response) {
  std::vector<std::string> lines;
  if (response.has_motion()) lines.push_back(PlanSummary(response.motion().quality()));
  if (!response.missing().empty()) lines.push_back(response.missing());
  return lines;
}

std::string FloorTitle(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  const v1::FloorPose& goal = request.goal();
  return fmt::format("{}: from here to {:.2f}, {:.2f}, heading {:.2f} rad",
                     OutcomeText(response.outcome()), goal.x_m(), goal.y_m(), goal.heading_rad());
}

}  // namespace

Canvas FloorPlanPicture(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  const std::vector<std::string> lines = LinesBelowTitle(response);
  const double top = HeadingHeight(lines.size());
  const FloorView view(BoundsOf(request, response), kLeft, top, {});
  const PictureFrame& frame = view.frame();
  Canvas canvas;
  AddFloorStyles(canvas);
  canvas.SetTitle(
      fmt::format("Plan in {}: {}", request.database(), OutcomeText(response.outcome())));
  canvas.SetSize(kLeft + frame.width + kRight, top + frame.height + kBottom);
  DrawHeading(canvas, frame.left, frame.width, FloorTitle(request, response), lines);
  DrawAxes(canvas, view);
  canvas.BeginGroup(frame);
  DrawObstacles(canvas, request, view);
  DrawGoal(canvas, request, view);
  // Better paths are drawn over worse ones, the best on top.
  for (int i = response.alternatives_size(); i-- > 0;) {
    DrawPath(canvas, response.alternatives(i), view, {"other", "other-pose", "other-heading"});
  }
  DrawPath(canvas, response.motion(), view, {"path", "pose", "heading"});
  DrawEnd(canvas, response.motion(), view);
  DrawStartMark(canvas, view.X(0), view.Y(0));
  canvas.EndGroup();
  canvas.Rectangle("frame", frame);
  DrawFloorLegend(canvas, request, response, view);
  return canvas;
}

}  // namespace motiondb::client
