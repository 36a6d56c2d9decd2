#include "client/cli/plot/body_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "client/cli/plot/picture.h"

namespace motiondb::client {
namespace {

using Json = nlohmann::json;

constexpr double kMargin = 24;
constexpr double kViewWidth = 380;
constexpr double kViewHeight = 480;
constexpr double kTop = 64;

void AddBodyStyles(Canvas& canvas) {
  canvas.AddStyle("bone", {.stroke = "#888", .stroke_width = 2, .round = true});
  canvas.AddStyle("left", {.fill = "#0072b2"});
  canvas.AddStyle("right", {.fill = "#d55e00"});
  canvas.AddStyle("middle", {.fill = "#009e73"});
  canvas.AddStyle("other", {.fill = "#bbb"});
}

struct ShownPoint {
  double x = 0, y = 0, z = 0;  // m, world
  int parent = -1;
  std::string name;
  std::string role;

  bool is_known() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(z); }
  const char* style() const {
    if (role.empty()) return "other";
    if (role.starts_with("left")) return "left";
    return role.starts_with("right") ? "right" : "middle";
  }
};

std::vector<ShownPoint> PointsOf(const Json& inspection) {
  std::vector<ShownPoint> points;
  for (const Json& item : inspection.at("points")) {
    const auto coordinate = [&](int axis) {
      const Json& value = item.at("position_m").at(axis);
      return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
    };
    points.push_back({coordinate(0), coordinate(1), coordinate(2), item.value("parent", -1),
                      item.value("name", ""), item.value("role", "")});
  }
  return points;
}

// Returns the direction on the floor from the right to the left hip, or the y axis.
std::pair<double, double> LeftDirection(const std::vector<ShownPoint>& points) {
  const auto hip = [&](std::string_view role) {
    return std::ranges::find_if(points,
                                [&](const auto& p) { return p.role == role && p.is_known(); });
  };
  const auto left = hip("left hip");
  const auto right = hip("right hip");
  if (left == points.end() || right == points.end()) return {0, 1};
  const double x = left->x - right->x;
  const double y = left->y - right->y;
  const double length = std::hypot(x, y);
  return length > 0 ? std::pair(x / length, y / length) : std::pair(0.0, 1.0);
}

// A projection of the points to a picture.
class View {
 public:
  // `x`, `y`: the horizontal direction in the world that points to the right of the picture.
  View(const std::vector<ShownPoint>& points, double x, double y, double left)
      : points_(points), x_(x), y_(y), left_(left) {
    double low = std::numeric_limits<double>::infinity(), high = -low, near = low, far = -low;
    for (const ShownPoint& point : points) {
      if (!point.is_known()) continue;
      near = std::min(near, Across(point));
      far = std::max(far, Across(point));
      low = std::min(low, point.z);
      high = std::max(high, point.z);
    }
    if (!(low <= high)) return;
    centre_ = (near + far) / 2;
    low_ = low;
    scale_ = std::min((kViewWidth - kMargin) / std::max(far - near, 1e-6),
                      (kViewHeight - kMargin) / std::max(high - low, 1e-6));
  }

  void Draw(Canvas& canvas, const std::string& title) const {
    canvas.Label("line", left_, kTop - 8, title);
    for (const ShownPoint& point : points_) {
      if (!point.is_known() || point.parent < 0) continue;
      const ShownPoint& parent = points_[static_cast<std::size_t>(point.parent)];
      if (parent.is_known()) canvas.Line("bone", X(parent), Y(parent), X(point), Y(point));
    }
    for (const ShownPoint& point : points_) {
      if (!point.is_known()) continue;
      canvas.Circle(point.style(), X(point), Y(point), point.role.empty() ? 2.5 : 4.5).tooltip =
          point.role.empty() ? point.name : point.name + ": " + point.role;
    }
  }

 private:
  double Across(const ShownPoint& point) const { return x_ * point.x + y_ * point.y; }
  double X(const ShownPoint& point) const {
    return left_ + kViewWidth / 2 + scale_ * (Across(point) - centre_);
  }
  double Y(const ShownPoint& point) const {
    return kTop + kViewHeight - kMargin / 2 - scale_ * (point.z - low_);
  }

  const std::vector<ShownPoint>& points_;
  const double x_, y_, left_;
  double centre_ = 0;
  double low_ = 0;
  double scale_ = 1;
};

}  // namespace

Canvas BodyPicture(const Json& inspection) {
  std::vector<ShownPoint> points = PointsOf(inspection);
  for (ShownPoint& point : points) {
    if (point.parent >= static_cast<int>(points.size())) point.parent = -1;
  }
  const auto [x, y] = LeftDirection(points);
  const double width = 2 * kViewWidth + 3 * kMargin;
  const std::string file = inspection.value("file", "");
  Canvas canvas;
  AddBodyStyles(canvas);
  canvas.SetTitle(file);
  canvas.SetSize(width, kTop + kViewHeight + kMargin);
  canvas.Label("title", kMargin, 28, TruncateToWidth(file, width - 2 * kMargin));
  // From the front the left side is on the right; from the left the front is on the left.
  View(points, x, y, kMargin).Draw(canvas, "from the front");
  View(points, -y, x, 2 * kMargin + kViewWidth).Draw(canvas, "from the left");
  return canvas;
}

}  // namespace motiondb::client
