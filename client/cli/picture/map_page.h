// The parts that all pictures of a map share: heading, the map with its axes, poses, legend.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/cli/picture/map_view.h"
#include "client/cli/picture/pose_drawing.h"

namespace motiondb::client {

struct MapOptions {
  MapAxes axes = {1, 2};
  MapColouring colouring = MapColouring::kByLabel;
  double width = 900;  // of the picture (pixels)
  double height = 700;
};

// A pose with lines of text below it.
struct CaptionedPose {
  std::vector<std::string> caption;
  Pose positions;
  Pose velocities;  // m/s; may be empty
  Pose then;        // what the motion was at that time, drawn behind; may be empty
};

// What surrounds the map.
struct MapPage {
  std::string title;
  std::vector<std::string> lines = {};  // below the title
  std::vector<LegendEntry> legend = {};
  std::vector<CaptionedPose> column = {};  // mean poses, right of the map
  std::vector<CaptionedPose> row = {};     // poses of a motion, below the map
  Bones bones = {};
};

// Draws the page around the map, with `draw_map(canvas, view)` inside its frame.
Canvas MapPagePicture(const StateMap& map, const MapOptions& options, const MapPage& page,
                      const std::function<void(Canvas& canvas, const MapView& view)>& draw_map);

// Draws the transitions to other nodes, as lines whose width grows with the probability, with a
// tooltip and an arrow. Of more than 5000, draws the most probable ones.
void DrawTransitions(Canvas& canvas, const StateMap& map, const MapView& view);

// Legend of the widths.
std::vector<LegendEntry> TransitionLegend();

// Draws the nodes as ellipses of one standard deviation, with a tooltip.
void DrawNodes(Canvas& canvas, const StateMap& map, const MapView& view, const MapColours& colours);

}  // namespace motiondb::client
