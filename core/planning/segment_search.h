// The search for stored segments that lead to the goal: best first over run and root pose, anytime
// (section V-C, beyond the paper's random sampling). Safe to call from any thread.
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
  std::uint32_t seed = 0;  // 0: joins cost what they are; others vary their cost
  double effort = 1;       // against the usual
};

struct FoundPath {
  SplicedPath path;
  double cost = 0;  // seconds, joins and correction as if they were time
  // What will be missing once the end is corrected; zero within tolerance.
  double lack = 0;
};

struct FoundPaths {
  std::vector<FoundPath> paths;  // reach the goal, cheapest first; else one that comes nearest
  bool reached = false;
  bool time_up = false;
  SearchEffort effort;
};

// Paths from a stored frame (whose reference frame is the floor's) that keep clear of the
// obstacles, whose field it is. A first answer early, better ones until nothing better is left or
// the effort is spent. Deterministic but for time_up. CANCELLED.
absl::StatusOr<FoundPaths> SearchSegments(SegmentGraph& graph, const StoredFloor& floor,
                                          int start_frame, const Obstacles& obstacles,
                                          const FloorField& field, const SearchSettings& settings,
                                          const PlanControl& control);

}  // namespace motiondb::core
