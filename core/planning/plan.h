// How do I get there? (section V-C): what a plan is asked for, what it is, and the search for it.
//
// The floor of a plan is the start's reference frame: origin below the hips at the start, x to the
// front, y to the left, metres and radians. Plain values; safe to call from any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"
#include "core/motion/states.h"
#include "core/planning/floor.h"
#include "core/planning/motion_quality.h"

namespace motiondb::core {

// Where a plan begins: a moment of a stored clip, the last frame of an observation, or standing
// still.
struct ClipMoment {
  std::string clip;  // ModelClip::id
  double seconds = 0;
};
struct PlanStart {
  // At most one of the two; neither means standing.
  std::optional<ClipMoment> clip;
  std::optional<StateSequence> observation;  // not scaled; the model's markers and frame rate
};

enum class PlanMethod {
  // Anytime search over stored segments whose ends share a node.
  kSegmentSearch,
  // The paper's: random walks on the coarse layer's graph, motion from the nodes' means.
  kRandomSampling,
};

struct PlanProblem {
  PlanStart start;
  FloorPose goal;
  double position_tolerance_m = 0.1;
  double heading_tolerance_rad = 0.1;
  double max_duration_seconds = 30;
  int coarse_layer = 0;             // 0: the default, about four fifths down the tree
  std::vector<std::string> labels;  // of clips that may be played; empty: all
  Obstacles obstacles;
  PlanMethod method = PlanMethod::kSegmentSearch;
  std::uint32_t seed = 0;
  int alternative_count = 0;  // plans beside the best
  // How hard to search, against the usual; the same effort gives the same plan on every machine.
  double effort = 1;
  // The body that is to play it; null leaves the plan on markers.
  std::shared_ptr<const Skeleton> skeleton;
  // Its heels and toes are points of flat soles, as the mappings of robots have them.
  bool flat_soles = false;
  bool respect_joint_limits = true;
  double frame_rate_hz = 0;  // of the answer; 0: the model's
  // Leg length (m) of a plan on markers alone; absent: that of the start's subject. A skeleton has
  // its own.
  std::optional<double> leg_length_m;
};

// How a caller ends the work. The first two are asked often, from the calling thread; all may be
// empty.
struct PlanControl {
  Cancelled cancelled;                // nothing is wanted any more
  std::function<bool()> time_up;      // the search ends; what it found is wanted
  std::function<void()> search_over;  // called once, when the search ends: the caller has the clock
};

enum class PlanOutcome {
  kExact,        // the motion ends at the goal, within tolerances, clear of obstacles
  kApproximate,  // the best that was found; `missing` says what it lacks
  kUnreachable,  // no stored motion leads there; `missing` says why
  kDeadline,     // time was up before the search was over; the best so far
};

// A run of stored frames that a plan plays.
struct PlayedSegment {
  std::int32_t first_frame = 0;  // of the model
  std::int32_t last_frame = 0;
};

struct PlanQuality {
  double position_error_m = 0;   // end of the motion against the goal
  double heading_error_rad = 0;  // not negative
  double length_m = 0;           // of the root's path
  double duration_seconds = 0;
  double correction_m = 0;                     // largest shift of the root path that the end needed
  double correction_heading_rad = 0;           // not negative
  std::optional<double> smallest_clearance_m;  // root path to obstacles; absent without any
  MotionQuality motion;
  // On a skeleton:
  double marker_fit_rms_m = 0;     // markers synthesised against those of the joint angles
  int joint_limit_violations = 0;  // frames x degrees of freedom beyond a limit
};

struct PlannedMotion {
  PlanOutcome outcome = PlanOutcome::kApproximate;
  std::string missing;  // empty where exact
  std::vector<PlayedSegment> segments;
  // At the model's frame rate, one node a frame.
  int coarse_layer = 0;
  std::vector<std::int32_t> coarse_nodes;
  std::vector<std::int32_t> bottom_nodes;
  // At the answer's frame rate. Markers are those of the joint angles where there is a skeleton.
  RootPath root;         // frames x 3: x, y, heading, of the markers' reference frames
  MarkerMotion markers;  // m, on the plan's floor
  std::optional<JointMotion> joints;
  PlanQuality quality;
};

struct SearchEffort {
  std::int64_t expansions = 0;  // states expanded, or walks sampled
  int improvements = 0;         // how often a better plan replaced the best
  bool complete = false;        // nothing was left to search among the joins looked at
};

struct PlanAnswer {
  PlanOutcome outcome = PlanOutcome::kUnreachable;  // of the best
  std::string missing;
  double leg_length_m = 0;             // the size that the plan is for
  std::vector<PlannedMotion> motions;  // best first; empty where not even a part was found
  SearchEffort effort;
};

class Model;

// INVALID_ARGUMENT naming the field that is out of range, NaN or unknown: numbers, labels and
// obstacles. The start and the body are checked where they are used. O(clips + corners log
// corners).
absl::Status CheckProblem(const Model& model, const PlanProblem& problem);

// The same for the obstacles of a problem.
absl::Status CheckObstacles(const Obstacles& obstacles);

// Searches for stored motion from the start to the goal, and makes one motion of it: segments
// blended at their joins, the end corrected by at most 5 % of the length, feet kept where they
// stand, joint angles on the skeleton. The outcome is judged on the motion that is returned.
// `scheme` is the one of the model's marker set: it maps the skeleton.
//
// The same problem gives the same answer as long as time is not up first. INVALID_ARGUMENT naming
// the field of the problem that is out of range, unknown or does not fit; NOT_FOUND for a clip that
// the model does not have; CANCELLED.
absl::StatusOr<PlanAnswer> PlanMotion(const Model& model, const MarkerScheme& scheme,
                                      const PlanProblem& problem, const PlanControl& control = {});

}  // namespace motiondb::core
