// The search graph of plans: short runs of stored frames. Each continues in its own clip or, by a
// join, in a similar run of the same node.
//
// Joins are computed on first use, so the cost follows the search, not the database. Use one object
// for each search. The model and the floor must outlive it.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/planning/playable.h"
#include "core/planning/splice.h"

namespace motiondb::core {

class Model;

// Consecutive frames of one playable range in one node of the coarse layer, at most 0.25 s.
struct Run {
  std::int32_t first = 0;
  std::int32_t last = 0;
  std::int32_t node = 0;
  bool continues = false;  // the next run is of the same range
};

struct RunJoin {
  Join join;
  std::int32_t to = 0;  // run that contains join.enter
  double distance = 0;  // mean square difference of the two states, each dimension scaled
  FloorPose across;     // see AcrossJoin
};

// Required similarity of the states of a join. Rough similarity causes more jerk, but a small
// database may offer nothing else.
enum class Similarity { kSimilar, kRoughlySimilar };

class SegmentGraph {
 public:
  // Creates the runs of the playable frames, by the nodes of `layer`. O(frames).
  SegmentGraph(const Model& model, const StoredFloor& floor, int layer, const Playable& playable,
               Similarity likeness = Similarity::kSimilar);

  const std::vector<Run>& runs() const { return runs_; }
  // Index of the run that contains a frame; -1 if it is not playable. O(log runs).
  int run_of_frame(int frame) const;
  // Maximum number of frames blended on each side of a join.
  int half_window() const { return half_window_; }
  // Whether a run has no glitch. Joins lead only to such runs.
  bool IsFreeOfGlitches(int run) const;
  // Returns the joins from a run, smallest distance first.
  const std::vector<RunJoin>& Joins(int run);

 private:
  // Returns the best join between two runs; nothing if none is similar enough.
  std::optional<RunJoin> BestJoin(int from, int to);
  // Returns the pose one second after the frame that a join enters.
  FloorPose Future(const RunJoin& join) const;
  // Keeps the best of the joins that lead to the same pose.
  std::vector<RunJoin> KeepDistinctFutures(std::vector<RunJoin> joins) const;
  double StateDistance(int a, int b) const;
  // half_window(), or less if a range has fewer frames around the join.
  int HalfWindowAt(const PlayableRange& from, int leave, const PlayableRange& to, int enter) const;
  const PlayableRange& RangeOf(int run) const { return ranges_[range_of_run_[run]]; }

  const Model& model_;
  const StoredFloor& floor_;
  const double largest_distance_;
  int half_window_ = 0;
  std::vector<Run> runs_;
  std::vector<PlayableRange> ranges_;
  std::vector<std::int32_t> range_of_run_;
  std::vector<std::vector<std::int32_t>> runs_of_node_;
  std::unordered_map<std::int32_t, std::vector<RunJoin>> joins_;  // by run, computed so far
};

}  // namespace motiondb::core
