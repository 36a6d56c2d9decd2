// How a map shows states: the principal axes in a frame of a picture, and the colours of clips.
#pragma once

#include <array>
#include <map>
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

enum class MapColouring { kByLabel, kByClip };

// Gives labels or clips their colours, those of the plots of a recognition. Of more than 8, those
// with most frames have colours, and the others are grey.
class MapColours {
 public:
  MapColours(const StateMap& map, MapColouring colouring);

  // Style names of a clip, by name: for points and areas, and for lines. Unknown clips are grey.
  std::string FillStyle(const std::string& clip) const;
  std::string LineStyle(const std::string& clip) const;

  // Adds the styles of both.
  static void AddStyles(Canvas& canvas);

  std::vector<LegendEntry> Legend() const;

 private:
  std::map<std::string, int> place_of_clip_;
  std::vector<std::string> names_;
  int other_count_ = 0;
  const char* kind_;
};

}  // namespace motiondb::client
