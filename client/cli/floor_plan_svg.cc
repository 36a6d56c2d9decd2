#include "client/cli/floor_plan_svg.h"

#include <fmt/format.h>
#include <motiondb/v1/plan.pb.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "client/cli/floor_view.h"
#include "client/cli/plan_text.h"
#include "client/cli/svg.h"

namespace motiondb::client {
namespace {

constexpr double kLeft = 70, kRight = 26, kBottom = 96;  // around the floor, pixels
constexpr double kTitleHeight = 30, kLineHeight = 20, kAboveFloor = 18;
constexpr double kPosesPerSecond = 6;
constexpr double kPoseRadius = 3.4, kHeadingLength = 15;
constexpr double kWedgeRadius = 46;
constexpr double kCharacterWidth = 6.6;  // of the lines below the title, about

constexpr const char* kStyle = R"(
    text { font-family: Helvetica, Arial, sans-serif; fill: #222; }
    .title { font-size: 18px; font-weight: bold; }
    .line { font-size: 13px; fill: #444; }
    .tick { font-size: 12px; fill: #555; }
    .grid { stroke: #e6e6e6; stroke-width: 1; }
    .frame { fill: none; stroke: #888; stroke-width: 1; }
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

std::string Circle(const char* style, double x, double y, double radius) {
  return fmt::format("<circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", style, N(x), N(y),
                     N(radius));
}

std::string Line(const char* style, double x1, double y1, double x2, double y2) {
  return fmt::format("<line class=\"{}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", style, N(x1),
                     N(y1), N(x2), N(y2));
}

std::string Text(const char* style, double x, double y, std::string_view text,
                 std::string_view attributes = "") {
  return fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\"{}{}>{}</text>\n", style, N(x), N(y),
                     attributes.empty() ? "" : " ", attributes, SvgText(text));
}

// A line of so many pixels from a point towards a heading. The picture's y points down.
std::string Ray(const char* style, double x, double y, double heading, double length) {
  return Line(style, x, y, x + length * std::cos(heading), y - length * std::sin(heading));
}

// ---- What is drawn on the floor -----------------------------------------------------------------

double Clearance(const v1::PlanRequest& request) {
  constexpr double kDefault = 0.3;  // the contract's
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

// Start, goal and paths; obstacles as far as they are near to these.
FloorBounds BoundsOf(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  FloorBounds bounds;  // the start is in it
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

// All obstacles in one style, each grown by `margin` pixels.
std::string Grown(const v1::Obstacles& obstacles, const FloorView& view, const char* style,
                  double margin) {
  std::string svg;
  for (const v1::Disc& disc : obstacles.discs()) {
    svg += Circle(style, view.X(disc.centre().x_m()), view.Y(disc.centre().y_m()),
                  view.Pixels(disc.radius_m()) + margin);
  }
  for (const v1::Polygon& polygon : obstacles.polygons()) {
    std::string points;
    for (const v1::FloorPoint& corner : polygon.corners()) {
      points += fmt::format("{}{},{}", points.empty() ? "" : " ", N(view.X(corner.x_m())),
                            N(view.Y(corner.y_m())));
    }
    // A wide line with round corners is what lies within the margin.
    const std::string width = margin > 0 ? fmt::format(" stroke-width=\"{}\"", N(2 * margin)) : "";
    svg += fmt::format("<polygon class=\"{}\"{} points=\"{}\"/>\n", style, width, points);
  }
  return svg;
}

// The edge first and the inside of all over it: overlapping clearances have one outline.
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
  if (half_angle >= std::numbers::pi) return Circle("wedge", x, y, kWedgeRadius);
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
  return Line("goal", x - kArm, y - kArm, x + kArm, y + kArm) +
         Line("goal", x - kArm, y + kArm, x + kArm, y - kArm) +
         Ray("goal", x, y, heading, kWedgeRadius);
}

std::string GoalSvg(const v1::PlanRequest& request, const FloorView& view) {
  const double x = view.X(request.goal().x_m());
  const double y = view.Y(request.goal().y_m());
  const double heading = request.goal().heading_rad();
  return Circle("tolerance", x, y, view.Pixels(PositionTolerance(request))) +
         WedgeSvg(x, y, heading, HeadingTolerance(request)) + GoalMark(x, y, heading);
}

std::string StartMark(double x, double y) {
  return Ray("start", x, y, 0, 16) + Circle("start", x, y, 4.5);
}

struct PathStyle {
  const char* path;
  const char* pose;
  const char* heading;
};

std::string PathSvg(const v1::PlannedMotion& motion, const FloorView& view,
                    const PathStyle& style) {
  constexpr double kLeastStep = 0.75;  // pixels: what nobody would see is left out
  std::string points;
  double last_x = 0, last_y = 0;
  for (int i = 0; i < motion.root_size(); ++i) {
    const double x = view.X(motion.root(i).x_m());
    const double y = view.Y(motion.root(i).y_m());
    const bool end = i == 0 || i == motion.root_size() - 1;
    if (!end && std::hypot(x - last_x, y - last_y) < kLeastStep) continue;
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
    poses += Circle(style.pose, x, y, kPoseRadius);
  }
  return svg + poses;
}

std::string EndSvg(const v1::PlannedMotion& motion, const FloorView& view) {
  if (motion.root_size() == 0) return "";
  const v1::FloorPose& end = motion.root(motion.root_size() - 1);
  const double x = view.X(end.x_m());
  const double y = view.Y(end.y_m());
  return Ray("heading", x, y, end.heading_rad(), kHeadingLength) + Circle("end", x, y, kPoseRadius);
}

// ---- What is around it --------------------------------------------------------------------------

std::string AxesSvg(const FloorView& view) {
  const PictureFrame& frame = view.frame();
  const FloorBounds& bounds = view.bounds();
  const double step = view.TickStep();
  const double bottom = frame.top + frame.height;
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  const auto label = [&](double value) { return fmt::format("{:.{}f}", value, decimals); };
  std::string grid, labels;
  for (const double x : Ticks(bounds.min_x, bounds.max_x, step)) {
    grid += Line("grid", view.X(x), frame.top, view.X(x), bottom);
    labels += Text("tick", view.X(x), bottom + 17, label(x), "text-anchor=\"middle\"");
  }
  for (const double y : Ticks(bounds.min_y, bounds.max_y, step)) {
    grid += Line("grid", frame.left, view.Y(y), frame.left + frame.width, view.Y(y));
    labels += Text("tick", frame.left - 8, view.Y(y) + 4, label(y), "text-anchor=\"end\"");
  }
  const double middle_y = frame.top + frame.height / 2;
  labels += Text("line", frame.left + frame.width / 2, bottom + 38, "to the front: x (m)",
                 "text-anchor=\"middle\"");
  labels +=
      Text("line", 20, middle_y, "to the left: y (m)",
           fmt::format("text-anchor=\"middle\" transform=\"rotate(-90 20.00 {})\"", N(middle_y)));
  return grid + labels;
}

std::string FrameSvg(const FloorView& view) {
  const PictureFrame& frame = view.frame();
  return fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n",
                     N(frame.left), N(frame.top), N(frame.width), N(frame.height));
}

// A sample of a style, and its name.
struct LegendEntry {
  const char* name;
  std::string (*sample)(double x, double y);
};

std::string LegendSvg(const v1::PlanRequest& request, const v1::PlanResponse& response,
                      const FloorView& view) {
  std::vector<LegendEntry> entries;
  entries.push_back({"start", [](double x, double y) { return StartMark(x, y); }});
  entries.push_back({"goal and tolerance", [](double x, double y) {
                       return Circle("tolerance", x + 4, y, 8) + Circle("goal", x + 4, y, 1);
                     }});
  if (response.has_motion()) {
    entries.push_back({"root and heading, every 1/6 s", [](double x, double y) {
                         return Line("path", x - 8, y, x + 16, y) +
                                Ray("heading", x, y, 0.8, kHeadingLength) +
                                Circle("pose", x, y, kPoseRadius);
                       }});
  }
  if (response.alternatives_size() > 0) {
    entries.push_back({"alternatives", [](double x, double y) {
                         return Line("other", x - 8, y, x + 16, y) +
                                Circle("other-pose", x + 4, y, kPoseRadius);
                       }});
  }
  if (request.obstacles().discs_size() + request.obstacles().polygons_size() > 0) {
    entries.push_back({"obstacle and clearance", [](double x, double y) {
                         return Circle("clearance-edge", x + 4, y, 9) +
                                Circle("clearance", x + 4, y, 8) + Circle("obstacle", x + 4, y, 4);
                       }});
  }
  std::string svg;
  const PictureFrame& frame = view.frame();
  double x = frame.left + 8;
  double y = frame.top + frame.height + 62;
  for (const LegendEntry& entry : entries) {
    const double width =
        48 + kCharacterWidth * static_cast<double>(std::string_view(entry.name).size());
    if (x + width > frame.left + frame.width + kRight && x > frame.left + 8) {
      x = frame.left + 8;
      y += 22;
    }
    svg += entry.sample(x, y) + Text("line", x + 26, y + 4, entry.name);
    x += width;
  }
  return svg;
}

// As much of a line as the picture is wide.
std::string Fitting(const std::string& text, double width) {
  const auto most = static_cast<size_t>(width / kCharacterWidth);
  if (text.size() <= most) return text;
  size_t cut = most - 3;
  while (cut > 0 && (text[cut] & 0xC0) == 0x80) --cut;  // not within a character
  return text.substr(0, cut) + "...";
}

// What is to be read under the title, a line each.
std::vector<std::string> LinesBelowTitle(const v1::PlanResponse& response) {
  std::vector<std::string> lines;
  if (response.has_motion()) lines.push_back(PlanFigures(response.motion().quality()));
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
  double y = kTitleHeight;
  std::string svg = Text("title", frame.left, y, Fitting(title, frame.width));
  for (const std::string& line : LinesBelowTitle(response)) {
    y += kLineHeight;
    svg += Text("line", frame.left, y, Fitting(line, frame.width));
  }
  return svg;
}

}  // namespace

std::string FloorPlanSvg(const v1::PlanRequest& request, const v1::PlanResponse& response) {
  const double top = kTitleHeight + kAboveFloor +
                     kLineHeight * static_cast<double>(LinesBelowTitle(response).size());
  const FloorView view(BoundsOf(request, response), kLeft, top, {});
  const PictureFrame& frame = view.frame();
  const double width = kLeft + frame.width + kRight;
  const double height = top + frame.height + kBottom;
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\">\n",
      N(width), N(height));
  svg += fmt::format("<title>Plan in {}: {}</title>\n<style>{}</style>\n",
                     SvgText(request.database()), OutcomeText(response.outcome()), kStyle);
  svg += fmt::format(
      "<clipPath id=\"floor\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n",
      N(frame.left), N(frame.top), N(frame.width), N(frame.height));
  svg += fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#fff\"/>\n", N(width), N(height));
  svg += TitleSvg(request, response, view) + AxesSvg(view);
  svg += "<g clip-path=\"url(#floor)\">\n";
  svg += ObstaclesSvg(request, view) + GoalSvg(request, view);
  // The best lies over the others, and the better ones over the worse.
  for (int i = response.alternatives_size(); i-- > 0;) {
    svg += PathSvg(response.alternatives(i), view, {"other", "other-pose", "other-heading"});
  }
  svg += PathSvg(response.motion(), view, {"path", "pose", "heading"});
  svg += EndSvg(response.motion(), view);
  svg += StartMark(view.X(0), view.Y(0)) + "</g>\n";
  svg += FrameSvg(view) + LegendSvg(request, response, view) + "</svg>\n";
  return svg;
}

}  // namespace motiondb::client
