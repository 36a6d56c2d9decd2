// A panel of the profile plot: the profiles of the clips of a layer in a frame, and a strip below
// with the label that wins each window. Coordinates and sizes are pixels, y downwards.
#pragma once

#include <map>
#include <string>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_layout.h"
#include "client/cli/plot/recognition_plot_profile.h"

namespace motiondb::client {

// Axes that all panels share.
struct PanelAxes {
  TimeAxis time;
  LogProbabilityAxis log_probability;
  std::map<std::string, int> label_indices;
};

// Heights of a panel: title, frame, strip, and all together.
constexpr double kPanelTitleHeight = 24;
constexpr double kPanelFrameHeight = 176;
constexpr double kStripGap = 5;
constexpr double kStripHeight = 16;
constexpr double kPanelHeight = kPanelTitleHeight + kPanelFrameHeight + kStripGap + kStripHeight;

void DrawPanel(Canvas& canvas, const LayerProfile& layer, const std::string& title,
               const PanelAxes& axes, const PictureFrame& frame);

// Adds the styles of the panels, chosen by one of their layers. With more clips, lines are
// thinner and paler. With more windows, more clips are the best of a window, and these lines are
// less bold.
void AddPanelStyles(Canvas& canvas, const LayerProfile& layer);

}  // namespace motiondb::client
