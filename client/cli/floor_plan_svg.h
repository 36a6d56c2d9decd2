// A plan seen from above, as in the paper's Fig. 16. Pure function.
#pragma once

#include <motiondb/messages.h>

#include <string>

#include "client/cli/picture.h"

namespace motiondb::client {

// An SVG file that needs no other: the root's path with a circle and a heading line every 1/6 s,
// start, goal with both tolerances, obstacles with the clearance around them, and alternatives in a
// lighter colour, over axes in metres; above it the outcome and its figures, below it a legend. The
// same messages make the same bytes.
std::string FloorPlanSvg(const v1::PlanRequest& request, const v1::PlanResponse& response);

// The part of a floor that a picture shows, and where its points are in the picture: x to the
// right, y upwards, one scale for both. Plain values; pure functions.

// A rectangle of the floor (m).
struct FloorBounds {
  double min_x = 0;
  double max_x = 0;
  double min_y = 0;
  double max_y = 0;

  // Grows to hold a disc; one that is not finite is passed over.
  void Add(double x, double y, double radius = 0);
  double width() const { return max_x - min_x; }
  double height() const { return max_y - min_y; }
};

class FloorView {
 public:
  // Shows `bounds` and a little around them, as large as it fits into the largest width and height,
  // but not narrower or lower than the least, for which more floor is shown.
  struct Limits {
    double least_width = 520;
    double least_height = 260;
    double largest_width = 860;
    double largest_height = 620;
  };
  FloorView(const FloorBounds& bounds, double left, double top, const Limits& limits);

  const FloorBounds& bounds() const { return bounds_; }
  const PictureFrame& frame() const { return frame_; }

  double X(double x_m) const { return frame_.left + (x_m - bounds_.min_x) * pixels_per_m_; }
  double Y(double y_m) const { return frame_.top + (bounds_.max_y - y_m) * pixels_per_m_; }
  double Pixels(double metres) const { return metres * pixels_per_m_; }

  // Metres between ticks.
  double TickStep() const { return client::TickStep(pixels_per_m_); }

 private:
  FloorBounds bounds_;
  PictureFrame frame_;
  double pixels_per_m_ = 1;
};

}  // namespace motiondb::client
