// A plan seen from above, as in the paper's Fig. 16.
#pragma once

#include <motiondb/messages.h>

#include "client/cli/plot/picture.h"

namespace motiondb::client {

// Returns a picture. It shows the root's path with a circle and a heading line
// every 1/6 s, start, goal with both tolerances, obstacles with clearance, and alternatives in a
// lighter colour. Axes are in metres. The heading has the outcome and its quality.
Canvas FloorPlanPicture(const v1::PlanRequest& request, const v1::PlanResponse& response);

// A rectangle of the floor (m).
struct FloorBounds {
  double min_x = 0;
  double max_x = 0;
  double min_y = 0;
  double max_y = 0;

  // Extends the bounds by a disc; ignores one that is not finite.
  void Add(double x, double y, double radius = 0);
  double width() const { return max_x - min_x; }
  double height() const { return max_y - min_y; }
};

// Maps a part of the floor to a picture: x to the right, y upwards, one scale for both.
class FloorView {
 public:
  // Shows `bounds` and a margin as large as the maximum width and height allow. Shows more floor if
  // the view would be smaller than the minimum. All limits in pixels.
  struct Limits {
    double min_width = 520;
    double min_height = 260;
    double max_width = 860;
    double max_height = 620;
  };
  FloorView(const FloorBounds& bounds, double left, double top, const Limits& limits);

  const FloorBounds& bounds() const { return bounds_; }
  const PictureFrame& frame() const { return frame_; }

  double X(double x_m) const { return frame_.left + (x_m - bounds_.min_x) * pixels_per_m_; }
  double Y(double y_m) const { return frame_.top + (bounds_.max_y - y_m) * pixels_per_m_; }
  double Pixels(double metres) const { return metres * pixels_per_m_; }

  // Distance between ticks (m).
  double TickStep() const { return client::TickStep(pixels_per_m_); }

 private:
  FloorBounds bounds_;
  PictureFrame frame_;
  double pixels_per_m_ = 1;
};

}  // namespace motiondb::client
