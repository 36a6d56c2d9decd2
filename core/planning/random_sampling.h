// The paper's search (section VI-E): random walks on the coarse layer's transition graph until one
// comes close to the goal, then the bottom layer's nodes for it, the motion being their means.
// Safe to call from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/segment_search.h"

namespace motiondb::core {

struct SampledPath {
  std::vector<std::int32_t> coarse_nodes;  // one a frame
  std::vector<std::int32_t> bottom_nodes;
  std::vector<FloorPose> root;  // integrated from the bottom nodes' mean velocities
  // Where the walk on the coarse layer came, by that layer's means: what the search went by.
  FloorPose coarse_end;
};

struct SampledPaths {
  std::vector<SampledPath> paths;  // those that came close; else the one that came nearest
  bool reached = false;            // by the coarse layer's means
  bool time_up = false;
  SearchEffort effort;
};

// Walks from the node of a stored frame, each step by the probabilities of eq. 6 over the clips
// with one of `labels` (empty: all); a walk ends at the goal, at an obstacle, where no transition
// leads on, or after the longest duration. CANCELLED.
absl::StatusOr<SampledPaths> SampleWalks(const Model& model, int layer, int start_frame,
                                         const std::vector<std::string>& labels,
                                         double leg_length_m, const Obstacles& obstacles,
                                         const SearchSettings& settings,
                                         const PlanControl& control);

// Marker positions (frames x 3 N_v, m) of bottom nodes' means, each where its reference frame is.
FrameMatrix MeanPositions(const Model& model, const std::vector<std::int32_t>& bottom_nodes,
                          const std::vector<FloorPose>& root, double leg_length_m);

}  // namespace motiondb::core
