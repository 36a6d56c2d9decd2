// Motion planning (section V-C): problem, answer, and the search.
//
// The floor of a plan is the start's reference frame: origin below the hips at the start, x to the
// front, y to the left, metres and radians.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"
#include "core/motion/robot.h"
#include "core/motion/states.h"
#include "core/planning/contacts.h"
#include "core/planning/floor.h"
#include "core/planning/motion_quality.h"
#include "core/planning/playable.h"
#include "core/planning/robot_forces.h"
#include "core/planning/time_stretch.h"

namespace motiondb::core {

// The start of a plan: a moment of a stored clip, the last frame of an observation, or standing.
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
  // Anytime search over stored segments that join in common nodes.
  kSegmentSearch,
  // The paper's method: random walks on the coarse layer's graph, motion from node means.
  kRandomSampling,
};

struct PlanProblem {
  PlanStart start;
  FloorPose goal;
  double position_tolerance_m = 0.1;
  double heading_tolerance_rad = 0.1;
  double max_duration_seconds = 30;  // slowed for joint limits, the motion is cut there
  std::optional<int> coarse_layer;   // none: the default, about four fifths down the tree
  Playable playable;                 // the stored motion to use
  Obstacles obstacles;
  PlanMethod method = PlanMethod::kSegmentSearch;
  std::uint32_t seed = 0;
  int alternative_count = 0;  // number of plans besides the best
  // Search effort relative to the default; equal efforts give equal plans on every machine.
  double effort = 1;
  // The body that plays the plan; null: markers only.
  std::shared_ptr<const Skeleton> skeleton;
  // The skeleton's heels and toes are points of flat soles, as in mappings of robots.
  bool flat_soles = false;
  bool respect_joint_limits = true;  // of position and speed
  // The skeleton's limits of speed and effort, and its masses; null: unknown.
  std::shared_ptr<const RobotDynamics> dynamics;
  double speed_limit_scale = 1;  // fraction of the limits of speed to use
  // rad/s^2, or m/s^2 of a translation: of every coordinate of PoseSteps but the root's.
  // Default: none. Requires a skeleton.
  std::optional<double> max_joint_acceleration;
  std::optional<double> frame_rate_hz;  // of the answer; none: the model's
  // Leg length (m) of a plan on markers only; default: that of the start's subject. A skeleton has
  // its own.
  std::optional<double> leg_length_m;
};

// Control by the caller. The first two are called often, from the calling thread; all may be empty.
struct PlanControl {
  Cancelled cancelled;                // stop without a result
  std::function<bool()> time_up;      // end the search, return the best so far
  std::function<void()> search_over;  // called once, when the first search ends, for timing
};

enum class PlanOutcome {
  kExact,        // the motion ends at the goal, within tolerances, clear of obstacles
  kApproximate,  // the best plan found; `missing`: what it lacks
  kUnreachable,  // no stored motion leads there; `missing`: the reason
  kDeadline,     // time was up before the search ended; the best so far
};

// Consecutive stored frames of a plan.
struct PlayedSegment {
  std::int32_t first_frame = 0;  // of the model
  std::int32_t last_frame = 0;
};

// The 0.4-s window of a plan that is least like stored motion.
struct UnlikeStored {
  double probability = 0;  // that the motion has none of the labels of the database
  double seconds = 0;      // middle of the window
};

struct PlanQuality {
  double position_error_m = 0;   // of the end of the motion
  double heading_error_rad = 0;  // not negative
  double length_m = 0;           // of the root's path
  double duration_seconds = 0;
  double correction_m = 0;            // maximum shift of the root path by the end correction
  double correction_heading_rad = 0;  // not negative
  std::optional<double> smallest_clearance_m;  // root path to obstacles; absent without any
  MotionQuality motion;
  std::optional<UnlikeStored> unknown;  // absent if the model is not calibrated for it
  // On a skeleton:
  double marker_fit_rms_m = 0;     // synthesised markers to those of the joint angles
  int joint_limit_violations = 0;  // number of angles beyond a limit
  RateViolations rate_violations;  // of the robot's speeds, scaled, and of the acceleration
  double recorded_seconds = 0;     // duration before time was stretched for joint limits
  double needed_seconds = 0;       // duration with stretched time; 0: no limit applies
};

struct PlannedMotion {
  PlanOutcome outcome = PlanOutcome::kApproximate;
  std::string missing;  // empty if exact
  std::vector<PlayedSegment> segments;
  // At the model's frame rate, one node for each frame before time is stretched.
  int coarse_layer = 0;
  std::vector<std::int32_t> coarse_nodes;
  std::vector<std::int32_t> bottom_nodes;
  // At the answer's frame rate. With a skeleton, markers are those of the joint angles.
  RootPath root;         // frames x 3: x, y, heading, of the markers' reference frames
  MarkerMotion markers;  // m, on the plan's floor
  std::optional<JointMotion> joints;
  ContactMatrix contacts;          // of the body's feet, of the stored frames
  std::vector<SlowedPart> slowed;  // for joint limits
  bool cut = false;                // slowed for joint limits, it does not end in time
  PlanQuality quality;
  std::optional<RobotForces> forces;  // if the robot's masses are known
};

struct SearchEffort {
  std::int64_t expansions = 0;  // states expanded, or walks sampled
  int improvements = 0;         // number of times a better plan was found
  bool complete = false;        // the whole search space of considered joins was searched
};

struct PlanAnswer {
  PlanOutcome outcome = PlanOutcome::kUnreachable;  // of the best
  std::string missing;
  double leg_length_m = 0;             // of the body
  std::vector<PlannedMotion> motions;  // best first; empty if not even a partial plan was found
  SearchEffort effort;
};

class Model;

// INVALID_ARGUMENT, naming the field, for numbers, labels or obstacles that are out of range, NaN
// or unknown. Start and body are checked where they are used. O(clips + corners log corners).
absl::Status CheckProblem(const Model& model, const PlanProblem& problem);

// As CheckProblem, for the obstacles only.
absl::Status CheckObstacles(const Obstacles& obstacles);

// Searches for stored motion from the start to the goal and synthesises one motion from it:
// segments blended at joins, the end corrected by at most 5 % of the length, standing feet kept in
// place, joint angles on the skeleton, slowed for its limits. The outcome is judged on the returned
// motion. If the body ends beside the goal, up to five more searches look for other paths.
// `scheme`, of the model's marker set, maps the skeleton.
//
// Deterministic unless time is up. INVALID_ARGUMENT naming the field of the problem that is out of
// range, unknown or does not fit; NOT_FOUND for an unknown clip; CANCELLED.
absl::StatusOr<PlanAnswer> PlanMotion(const Model& model, const MarkerScheme& scheme,
                                      const PlanProblem& problem, const PlanControl& control = {});

}  // namespace motiondb::core
