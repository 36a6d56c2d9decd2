// The probabilities and the familiarity of an answer, drawn in frames of the plot.
#pragma once

#include <string>
#include <vector>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_answer.h"
#include "client/cli/plot/recognition_plot_frame.h"

namespace motiondb::client {

// Returns stacked areas: the labels in `drawn` (one for each label of the answer), all other labels
// in grey, and from the upper edge downwards unknown motion. Each column is as wide as its cell.
std::string ProbabilityAreasSvg(const RecognitionAnswer& answer, const std::vector<bool>& drawn,
                                const TimeAxis& time_axis, const PictureFrame& frame);

// Returns a line with a step for each column, and gaps where the familiarity is not finite.
std::string FamiliaritySvg(const RecognitionAnswer& answer, const TimeAxis& time_axis,
                           const PictureFrame& frame);

// Returns an invisible rectangle for each column, whose tooltip has the values of its window.
std::string TooltipsSvg(const RecognitionAnswer& answer, const TimeAxis& time_axis,
                        const PictureFrame& frame);

// Returns their style sheet, and the definition of the hatching, which the file needs.
std::string AreaStyleSheet();
std::string HatchingSvg();

}  // namespace motiondb::client
