// The answer of a recognition over time, as a picture.
#pragma once

#include <motiondb/messages.h>

#include "client/cli/plot/canvas.h"

namespace motiondb::client {

// Returns a picture of the probabilities of labels and of unknown motion
// (hatched) as stacked areas, a strip with the answer of each window, a strip with its best clip,
// and its familiarity. The answer is the most probable label, or "unknown" if its probability is
// above `unknown_threshold`. Clips whose names do not fit in the strip have numbers. Windows with
// invalid times and values that are not finite are omitted.
Canvas RecognitionPicture(const v1::RecognizeRequest& request,
                          const v1::RecognizeResponse& response, double unknown_threshold);

}  // namespace motiondb::client
