// The principal axes in a frame of a picture.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/cli/picture/state_map.h"
#include "client/cli/plot/picture.h"

namespace motiondb::client {

// Two axes, or three in an oblique view: 1, 2 or 3.
using MapAxes = std::vector<int>;

// A parallel projection to a frame, with the same scale in both directions, so that the map fills
// the frame. REQUIRES: `axes` has two or three different elements.
class MapView {
 public:
  MapView(const StateMap& map, MapAxes axes, const PictureFrame& frame);

  const MapAxes& axes() const { return axes_; }
  const PictureFrame& frame() const { return frame_; }
  bool is_oblique() const { return axes_.size() == 3; }

  // Position in the picture.
  Point At(const AxisVector& position) const;

  // The outline of an ellipsoid with these semi-axes, seen in the view.
  EllipseShape Outline(const AxisVector& centre, const std::array<AxisVector, 3>& semi_axes) const;

  // Draws the grid with its captions, or in an oblique view the plane of the first two axes.
  void DrawAxes(Canvas& canvas, const StateMap& map) const;

 private:
  Point Projected(const AxisVector& position) const;  // scaled units, y upwards
  void DrawObliqueAxes(Canvas& canvas, const StateMap& map) const;

  MapAxes axes_;
  PictureFrame frame_;
  std::array<Point, 3> directions_;  // of the three axes, projected
  Point low_, high_;                 // shown part of the plane
  AxisVector least_ = {}, most_ = {};
  double scale_ = 1;  // pixels per unit
};

// "axis 1 (34 % of the variance)"
std::string AxisCaption(const StateMap& map, int axis);

}  // namespace motiondb::client
