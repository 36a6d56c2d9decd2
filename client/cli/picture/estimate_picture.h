// An observed motion in a map, as in the paper's Figs. 11 and 12.
#pragma once

#include <motiondb/messages.h>
#include <motiondb/v1/query.pb.h>

#include <string>
#include <vector>

#include "client/cli/picture/map_picture.h"

namespace motiondb::client {

// The estimate and the prediction at a moment of a motion.
struct EstimatedMotion {
  std::string file;
  std::vector<int> path;           // node of each frame up to the moment
  v1::PredictResponse prediction;  // with next nodes and horizons
  std::vector<MeanPose> next;      // of the first next nodes
  Pose now;                        // at the moment
  std::vector<Pose> then;          // at the horizons; empty after the end of the motion
};

// Number of next nodes whose mean poses are drawn.
inline constexpr int kNextPoses = 4;

// Draws the node path over all nodes, the next nodes with their probabilities and mean poses, and
// below them the pose at the moment and the predicted poses with their expected errors, over what
// the motion was then.
Canvas EstimatePicture(const StateMap& map, const EstimatedMotion& motion,
                       const std::string& database, const MapOptions& options, const Bones& bones);

}  // namespace motiondb::client
