// Anytime best-first search over runs and root poses for stored segments that lead to the goal
// (section V-C; replaces the paper's random sampling).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/floor.h"
#include "core/planning/plan.h"
#include "core/planning/segment_graph.h"

namespace motiondb::core {

struct SearchSettings {
  FloorPose goal;  // in the start's reference frame
  double position_tolerance_m = 0.1;
  double heading_tolerance_rad = 0.1;
  double max_duration_seconds = 30;
  double frame_rate_hz = 60;  // of the model
  int path_count = 1;
  std::uint32_t seed = 0;  // 0: true costs of joins; others: randomised costs
  double effort = 1;       // relative to the default
};

struct FoundPath {
  SplicedPath path;
  double cost = 0;  // seconds, with joins and correction converted to time
  // Remaining violation of the tolerances after correction; 0: within tolerance.
  double violation = 0;
};

struct FoundPaths {
  std::vector<FoundPath> paths;  // to the goal, cheapest first; else the nearest one
  bool reached = false;
  bool time_up = false;
  SearchEffort effort;
};

// Returns paths from a stored frame, whose reference frame is the floor's, that keep clear of the
// obstacles; `field` is their field. Finds a first answer early and improves it until the search is
// complete or the effort is spent. Deterministic except for time_up. CANCELLED.
absl::StatusOr<FoundPaths> SearchSegments(SegmentGraph& graph, const StoredFloor& floor,
                                          int start_frame, const Obstacles& obstacles,
                                          const FloorField& field, const SearchSettings& settings,
                                          const PlanControl& control);

}  // namespace motiondb::core
