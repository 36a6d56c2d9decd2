// The graph that a plan is searched in: short runs of stored frames, each of which goes on in its
// own clip or, by a join, in another run of the same node that is like it.
//
// Joins are found when they are first asked for, so the cost follows the search, not the database.
// Thread-compatible: one object a search. The model and the floor must outlive it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/planning/splice.h"

namespace motiondb::core {

class Model;
struct ModelClip;

// Frames of one clip in one node of the coarse layer, at most a quarter of a second of them.
struct Run {
  std::int32_t first = 0;
  std::int32_t last = 0;
  std::int32_t node = 0;
  bool goes_on = false;  // the next run is of the same clip
};

struct RunJoin {
  Join join;
  std::int32_t to = 0;  // run that holds join.enter
  double distance = 0;  // mean square difference of the two states, each dimension scaled
  FloorPose across;     // see AcrossJoin
};

// How alike the states of a join must be. Roughly alike ones jerk more, but where little is stored
// nothing else may lead on.
enum class Likeness { kAlike, kRoughlyAlike };

class SegmentGraph {
 public:
  // Runs of the clips with one of `labels` (empty: all), by the nodes of `layer`. O(frames).
  SegmentGraph(const Model& model, const StoredFloor& floor, int layer,
               const std::vector<std::string>& labels, Likeness likeness = Likeness::kAlike);

  const std::vector<Run>& runs() const { return runs_; }
  // Index of the run that holds a frame; -1 where the frame is of no clip that may be played.
  // O(log runs).
  int run_of_frame(int frame) const;
  // Frames on each side of a join that both clips have, at most.
  int half_window() const { return half_window_; }
  // Whether a run plays without a glitch of its recording. Joins lead to no other.
  bool Plays(int run) const;
  // The joins that leave a run, least distance first.
  const std::vector<RunJoin>& Joins(int run);

 private:
  // The best join between two runs, if there is one that is good enough.
  std::optional<RunJoin> BestJoin(int from, int to);
  // Where the frame that a join enters leads in a second.
  FloorPose Future(const RunJoin& join) const;
  // The best of the joins among those that lead to the same place.
  std::vector<RunJoin> LeadingApart(std::vector<RunJoin> joins) const;
  double StateDistance(int a, int b) const;
  // At most half_window(), where two runs' clips have fewer frames about a join.
  int HalfWindowAt(const ModelClip& from, int leave, const ModelClip& to, int enter) const;
  const ModelClip& ClipOf(int run) const;

  const Model& model_;
  const StoredFloor& floor_;
  const double largest_distance_;
  int half_window_ = 0;
  std::vector<Run> runs_;
  std::vector<std::int32_t> clip_of_run_;
  std::vector<std::vector<std::int32_t>> runs_of_node_;
  std::unordered_map<std::int32_t, std::vector<RunJoin>> joins_;  // of the runs asked about
};

}  // namespace motiondb::core
