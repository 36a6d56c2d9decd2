// The paper's search (section VI-E): random walks on the coarse layer's transition graph until one
// comes close to the goal; then the bottom layer's nodes for it. The motion is their means.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/segment_search.h"

namespace motiondb::core {

struct SampledPath {
  std::vector<std::int32_t> coarse_nodes;  // one for each frame
  std::vector<std::int32_t> bottom_nodes;
  std::vector<FloorPose> root;  // integrated from the bottom nodes' mean velocities
  // End of the walk by the coarse layer's means, which the search uses.
  FloorPose coarse_end;
};

struct SampledPaths {
  std::vector<SampledPath> paths;  // walks that reach the goal; else the nearest one
  bool reached = false;            // by the coarse layer's means
  bool time_up = false;
  SearchEffort effort;
};

// Random walks from the node of a stored frame, by the probabilities of eq. 6 over the playable
// motion. A walk ends at the goal, at an obstacle, at a node without
// transitions, or after the maximum duration. CANCELLED.
absl::StatusOr<SampledPaths> SampleWalks(const Model& model, int layer, int start_frame,
                                         const Playable& playable, double leg_length_m,
                                         const Obstacles& obstacles, const SearchSettings& settings,
                                         const PlanControl& control);

// Returns the marker positions (frames x 3 N_v, m) of bottom nodes' means at the reference frames
// `root`.
FrameMatrix MeanPositions(const Model& model, const std::vector<std::int32_t>& bottom_nodes,
                          const std::vector<FloorPose>& root, double leg_length_m);

}  // namespace motiondb::core
