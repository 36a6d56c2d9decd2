#include "client/cli/plot/floor_plan_svg.h"

#include <fmt/format.h>
#include <motiondb/v1/plan.pb.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
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

constexpr const char* kFloorStyle = R"(
    .clearance-edge { fill: #d9a066; stroke: #d9a066; stroke-linejoin: round; }
    .clearance { fill: #fbeedd; stroke: #fbeedd; stroke-linejoin: round; }
    .obstacle { fill: #b9834f; stroke: #7d5427; stroke-width: 1; }
    .tolerance { fill: #d62728; fill-opacity: 0.10; stroke: #d62728; stroke-width: 1.2; stroke-dasharray: 4 3; }
    .wedge { fill: #d62728; fill-opacity: 0.22; stroke: none; }
    .goal { fill: none; stroke: #d62728; stroke-width: 2; stroke-linecap: round; }
    .start { fill: #222; stroke: #222; stroke-width: 2; stroke-linecap: round; }
    .path { fill: none; stroke: #1f5fbf; stroke-width: 1.4; stroke-linejoin: round; }
    .pose { fill: #fff; stroke: #1f5fbf; stroke-width: 1.4; }
    .end { fill: #1f5fbf; stroke: #1f5fbf; stroke-width: 1.4; }
    .heading { stroke: #2a9d4a; stroke-width: 1.8; stroke-linecap: round; }
    .other { fill: none; stroke: #b4c7e3; stroke-width: 1.4; stroke-linejoin: round; }
    .other-pose { fill: #fff; stroke: #b4c7e3; stroke-width: 1; }
    .other-heading { stroke: #b9dfc4; stroke-width: 1.4; stroke-linecap: round; }
)";

std::string N(double value) { return SvgNumber(value); }

// A line of `length` pixels from a point in a direction. The picture's y axis points down.
std::string Ray(const char* style, double x, double y, double heading, double length) {
  return SvgLine(style, x, y, x + length * std::cos(heading), y - length * std::sin(heading));
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
std::string Grown(const v1::Obstacles& obstacles, const FloorView& view, const char* style,
                  double margin) {
  std::string svg;
  for (const v1::Disc& disc : obstacles.discs()) {
    svg += SvgCircle(style, view.X(disc.centre().x_m()), view.Y(disc.centre().y_m()),
                     view.Pixels(disc.radius_m()) + margin);
  }
  for (const v1::Polygon& polygon : obstacles.polygons()) {
    std::string points;
    for (const v1::FloorPoint& corner : polygon.corners()) {
      points += fmt::format("{}{},{}", points.empty() ? "" : " ", N(view.X(corner.x_m())),
                            N(view.Y(corner.y_m())));
    }
    // A wide outline with round corners covers the margin.
    const std::string width = margin > 0 ? fmt::format(" stroke-width=\"{}\"", N(2 * margin)) : "";
    svg += fmt::format("<polygon class=\"{}\"{} points=\"{}\"/>\n", style, width, points);
  }
  return svg;
}

// Draws all edges first and all insides over them, so that overlapping clearances have one outline.
std::string ObstaclesSvg(const v1::PlanRequest& request, const FloorView& view) {
  const double clearance = view.Pixels(Clearance(request));
  const v1::Obstacles& obstacles = request.obstacles();
  std::string svg;
  if (clearance > 0) {
    svg += Grown(obstacles, view, "clearance-edge", clearance + 1);
    svg += Grown(obstacles, view, "clearance", clearance);
  }
  return svg + Grown(obstacles, view, "obstacle", 0);
}

std::string WedgeSvg(double x, double y, double heading, double half_angle) {
  if (half_angle >= std::numbers::pi) return SvgCircle("wedge", x, y, kWedgeRadius);
  const auto edge = [&](double angle) {
    return fmt::format("{} {}", N(x + kWedgeRadius * std::cos(angle)),
                       N(y - kWedgeRadius * std::sin(angle)));
  };
  return fmt::format("<path class=\"wedge\" d=\"M {} {} L {} A {} {} 0 {} 0 {} Z\"/>\n", N(x), N(y),
                     edge(heading - half_angle), N(kWedgeRadius), N(kWedgeRadius),
                     half_angle > std::numbers::pi / 2 ? 1 : 0, edge(heading + half_angle));
}

std::string GoalMark(double x, double y, double heading) {
  constexpr double kArm = 5;
  return SvgLine("goal", x - kArm, y - kArm, x + kArm, y + kArm) +
         SvgLine("goal", x - kArm, y + kArm, x + kArm, y - kArm) +
         Ray("goal", x, y, heading, kWedgeRadius);
}

std::string GoalSvg(const v1::PlanRequest& request, const FloorView& view) {
  const double x = view.X(request.goal().x_m());
  const double y = view.Y(request.goal().y_m());
  const double heading = request.goal().heading_rad();
  return SvgCircle("tolerance", x, y, view.Pixels(PositionTolerance(request))) +
         WedgeSvg(x, y, heading, HeadingTolerance(request)) + GoalMark(x, y, heading);
}

std::string StartMark(double x, double y) {
  return Ray("start", x, y, 0, 16) + SvgCircle("start", x, y, 4.5);
}

struct PathStyle {
  const char* path;
  const char* pose;
  const char* heading;
};

std::string PathSvg(const v1::PlannedMotion& motion, const FloorView& view,
                    const PathStyle& style) {
  constexpr double kMinStep = 0.75;  // pixels; closer points are omitted
  std::string points;
  double last_x = 0, last_y = 0;
  for (int i = 0; i < motion.root_size(); ++i) {
    const double x = view.X(motion.root(i).x_m());
    const double y = view.Y(motion.root(i).y_m());
    const bool end = i == 0 || i == motion.root_size() - 1;
    if (!end && std::hypot(x - last_x, y - last_y) < kMinStep) continue;
    points += fmt::format("{}{},{}", points.empty() ? "" : " ", N(x), N(y));
    last_x = x;
    last_y = y;
  }
  std::string svg =
      points.empty() ? ""
                     : fmt::format("<polyline class=\"{}\" points=\"{}\"/>\n", style.path, points);
  const double step = motion.frame_rate_hz() / kPosesPerSecond;
  if (!(step > 0)) return svg;
  std::string poses;
  int last_frame = -1;
  for (int i = 0;; ++i) {
    const double exact = std::round(i * step);
    if (exact >= motion.root_size()) break;
    const int frame = static_cast<int>(exact);
    if (frame == last_frame) continue;
    last_frame = frame;
    const v1::FloorPose& pose = motion.root(frame);
    const double x = view.X(pose.x_m());
    const double y = view.Y(pose.y_m());
    svg += Ray(style.heading, x, y, pose.heading_rad(), kHeadingLength);
    poses += SvgCircle(style.pose, x, y, kPoseRadius);
  }
  return svg + poses;
}

std::string EndSvg(const v1::PlannedMotion& motion, const FloorView& view) {
  if (motion.root_size() == 0) return "";
  const v1::FloorPose& end = motion.root(motion.root_size() - 1);
  const double x = view.X(end.x_m());
  const double y = view.Y(end.y_m());
  return Ray("heading", x, y, end.heading_rad(), kHeadingLength) +
         SvgCircle("end", x, y, kPoseRadius);
}

// ---- Axes, legend, heading ----------------------------------------------------------------------

std::string AxesSvg(const FloorView& view) {
  const PictureFrame& frame = view.frame();
  const FloorBounds& bounds = view.bounds();
  const double step = view.TickStep();
  const std::vector<Tick> x_ticks =
      LinearTicks(bounds.min_x, bounds.max_x, step, [&](double x) { return view.X(x); });
  const std::vector<Tick> y_ticks =
      LinearTicks(bounds.min_y, bounds.max_y, step, [&](double y) { return view.Y(y); });
  return GridSvg(frame, x_ticks, y_ticks) + XTicksSvg(frame.bottom(), x_ticks) +
         YTicksSvg(frame, y_ticks) + XCaptionSvg(frame, frame.bottom(), "to the front: x (m)") +
         YCaptionSvg(frame, "to the left: y (m)");
}

std::string FloorLegendSvg(const v1::PlanRequest& request, const v1::PlanResponse& response,
                           const FloorView& view) {
  std::vector<LegendEntry> entries;
  entries.push_back({"start", [](double x, double y) { return StartMark(x, y); }});
  entries.push_back({"goal and tolerance", [](double x, double y) {
                       return SvgCircle("tolerance", x + 4, y, 8) + SvgCircle("goal", x + 4, y, 1);
                     }});
  if (response.has_motion()) {
    entries.push_back({"root and heading, every 1/6 s", [](double x, double y) {
                         return SvgLine("path", x - 8, y, x + 16, y) +
                                Ray("heading", x, y, 0.8, kHeadingLength) +
                                SvgCircle("pose", x, y, kPoseRadius);
                       }});
  }
  if (response.alternatives_size() > 0) {
    entries.push_back({"alternatives", [](double x, double y) {
                         return SvgLine("other", x - 8, y, x + 16, y) +
                                SvgCircle("other-pose", x + 4, y, kPoseRadius);
                       }});
  }
  if (request.obstacles().discs_size() + request.obstacles().polygons_size() > 0) {
    entries.push_back({"obstacle and clearance", [](double x, double y) {
                         return SvgCircle("clearance-edge", x + 4, y, 9) +
                                SvgCircle("clearance", x + 4, y, 8) +
                                SvgCircle("obstacle", x + 4, y, 4);
                       }});
  }
  const PictureFrame& frame = view.frame();
  return LegendSvg(entries, frame.left + 8, frame.right() + kRight, frame.bottom() + 62).svg;
}

// Returns the lines below the title.
std::vector<std::string> LinesBelowTitle(const v1::PlanResponse& response) {
  std::vector<std::string> lines;
  if (response.has_motion()) lines.push_back(PlanSummary(response.motion().quality()));
  if (!response.missing().empty()) lines.push_back(response.missing());
  return lines;
}

std::string TitleSvg(const v1::PlanRequest& request, const v1::PlanResponse& response,
                     const FloorView& view) {
  const PictureFrame& frame = view.frame();
  const v1::FloorPose& goal = request.goal();
  const std::string title =
      fmt::format("{}: from here to {:.2f}, {:.2f}, heading {:.2f} rad",
                  OutcomeText(response.outcome()), goal.x_m(), goal.y_m(), goal.heading_rad());
  return HeadingSvg(frame.left, frame.width, title, LinesBelowTitle(response));
}

}  // namespace

std::string FloorPlanSvg(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  const double top = HeadingHeight(LinesBelowTitle(response).size());
  const FloorView view(BoundsOf(request, response), kLeft, top, {});
  const PictureFrame& frame = view.frame();
  const double width = kLeft + frame.width + kRight;
  const double height = top + frame.height + kBottom;
  std::string svg = PictureHead(
      width, height,
      fmt::format("Plan in {}: {}", request.database(), OutcomeText(response.outcome())),
      kFloorStyle);
  svg += ClipPathSvg("floor", frame) + BackgroundSvg(width, height);
  svg += TitleSvg(request, response, view) + AxesSvg(view);
  svg += "<g clip-path=\"url(#floor)\">\n";
  svg += ObstaclesSvg(request, view) + GoalSvg(request, view);
  // Better paths are drawn over worse ones, the best on top.
  for (int i = response.alternatives_size(); i-- > 0;) {
    svg += PathSvg(response.alternatives(i), view, {"other", "other-pose", "other-heading"});
  }
  svg += PathSvg(response.motion(), view, {"path", "pose", "heading"});
  svg += EndSvg(response.motion(), view);
  svg += StartMark(view.X(0), view.Y(0)) + "</g>\n";
  svg += FrameSvg(frame) + FloorLegendSvg(request, response, view) + "</svg>\n";
  return svg;
}

}  // namespace motiondb::client
