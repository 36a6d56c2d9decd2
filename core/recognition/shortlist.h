// Which clips are worth aligning with a window: those whose nodes it comes near. Safe to call from
// any thread.
#pragma once

#include <vector>

#include "core/model/model.h"

namespace motiondb::core {

// At most 64 clips, the nearest first. `observed`: frames x K, in the metric. A clip is as far as
// the mean, over at most 24 of the frames spread evenly, of the squared distance to the nearest
// mean among its nodes; only the 64 nodes nearest to a frame are looked at, and to the others it is
// taken to be as far as to the 64th. Noise moves an observation away from all nodes alike, so the
// order stays. Clips with `left_out[clip]` are passed over; it may be empty. Of the rest there is
// none that a database of 64 clips leaves out. The cost does not grow with the number of clips but
// for those found in these nodes.
std::vector<int> ShortlistClips(const Model& model, const FrameMatrix& observed,
                                const std::vector<bool>& left_out = {});

}  // namespace motiondb::core
