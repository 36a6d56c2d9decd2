// The probabilities and the familiarity of an answer, drawn in frames of the plot.
#pragma once

#include <string>
#include <vector>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_answer.h"
#include "client/cli/plot/recognition_plot_layout.h"

namespace motiondb::client {

// Draws stacked areas: the labels in `drawn` (one for each label of the answer), all other labels
// in grey, and from the upper edge downwards unknown motion. Each column is as wide as its cell.
// Returns whether there is any area.
bool DrawProbabilityAreas(Canvas& canvas, const RecognitionAnswer& answer,
                          const std::vector<bool>& drawn, const TimeAxis& time_axis,
                          const PictureFrame& frame);

// Draws a line with a step for each column, and gaps where the familiarity is not finite.
void DrawFamiliarity(Canvas& canvas, const RecognitionAnswer& answer, const TimeAxis& time_axis,
                     const PictureFrame& frame);

// Adds an invisible rectangle for each column, whose tooltip has the values of its window.
void AddTooltips(Canvas& canvas, const RecognitionAnswer& answer, const TimeAxis& time_axis,
                 const PictureFrame& frame);

// Adds the styles of areas.
void AddAreaStyles(Canvas& canvas);

}  // namespace motiondb::client
