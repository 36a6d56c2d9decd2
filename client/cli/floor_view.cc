#include "client/cli/floor_view.h"

#include <algorithm>
#include <cmath>

namespace motiondb::client {
namespace {

constexpr double kBorder = 0.06;       // of the larger extent, around what is shown
constexpr double kLeastExtentM = 0.5;  // of a picture of standing still

// Widens [low, high] about its middle to an extent.
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
  const double border = kBorder * std::max({bounds.width(), bounds.height(), kLeastExtentM});
  Widen(std::max(bounds.width(), kLeastExtentM) + 2 * border, bounds_.min_x, bounds_.max_x);
  Widen(std::max(bounds.height(), kLeastExtentM) + 2 * border, bounds_.min_y, bounds_.max_y);
  pixels_per_m_ =
      std::min(limits.largest_width / bounds_.width(), limits.largest_height / bounds_.height());
  Widen(limits.least_width / pixels_per_m_, bounds_.min_x, bounds_.max_x);
  Widen(limits.least_height / pixels_per_m_, bounds_.min_y, bounds_.max_y);
  frame_ = {left, top, Pixels(bounds_.width()), Pixels(bounds_.height())};
}

}  // namespace motiondb::client
