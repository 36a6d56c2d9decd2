// One layer in a picture of recognition: the profiles of all clips in a frame, and a strip below it
// with the label that wins each window. Sizes and places are pixels, y downwards. Pure functions.
#pragma once

#include <map>
#include <string>

#include "client/cli/picture.h"
#include "client/cli/recognition_plot.h"

namespace motiondb::client {

// What all panels of a picture share.
struct PanelAxes {
  double start_seconds = 0;
  double end_seconds = 1;
  LogProbabilityAxis log_probability;
  std::map<std::string, int> label_places;
};

// A panel's heights: of the frame, and of all with the title above and the strip below.
constexpr double kPanelTitleHeight = 24;
constexpr double kPanelFrameHeight = 176;
constexpr double kStripGap = 5;
constexpr double kStripHeight = 16;
constexpr double kPanelHeight = kPanelTitleHeight + kPanelFrameHeight + kStripGap + kStripHeight;

std::string PanelSvg(const LayerProfile& layer, const std::string& title, const PanelAxes& axes,
                     const PictureFrame& frame);

// Where a time is.
double PanelX(const PanelAxes& axes, const PictureFrame& frame, double seconds);

// The numbers of the time axis.
std::vector<Tick> TimeTicks(const PanelAxes& axes, const PictureFrame& frame);

// The styles of the panels, of which `layer` is one: the more clips, the thinner and paler the
// lines; in many windows many clips are the best, which then stand out less.
std::string PanelStyleSheet(const LayerProfile& layer);

}  // namespace motiondb::client
