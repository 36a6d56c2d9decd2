// Pictures of a model in its principal axes.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/cli/picture/map_page.h"

namespace motiondb::client {

// A node at an end of an axis.
struct ExtremeNode {
  int axis = 1;
  bool is_high = false;
  int node = 0;  // index in the map
};

// Returns the nodes with the lowest and the highest mean on each of the two first axes of the view.
std::vector<ExtremeNode> ExtremeNodes(const StateMap& map, const MapAxes& axes);

// The mean pose of a node.
struct MeanPose {
  Pose positions;   // m, in the reference frame
  Pose velocities;  // m/s
};

// Frames as points, nodes and transitions, as in the paper's Figs. 6 to 8. `poses`: of
// ExtremeNodes, or empty; letters mark their nodes.
Canvas MapPicture(const StateMap& map, const std::string& database, const MapOptions& options,
                  const std::vector<MeanPose>& poses, const Bones& bones);

// Nodes as ellipses and the global transition graph, as in Fig. 9.
Canvas LayerPicture(const StateMap& map, const std::string& database, const MapOptions& options);

// A pose at a time of a clip (s).
struct ClipMoment {
  double seconds = 0;
  Pose positions;
};

// The transition graph of a clip over all nodes, as in Fig. 10, and poses along the clip.
Canvas ClipPicture(const StateMap& map, const StateMap& clip_map, const std::string& clip,
                   const MapOptions& options, const std::vector<ClipMoment>& moments,
                   const Bones& bones);

}  // namespace motiondb::client
