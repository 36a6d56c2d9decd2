#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/inference/node_path.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/body.h"
#include "core/planning/extrapolation.h"
#include "core/planning/plan.h"
#include "core/planning/random_sampling.h"
#include "core/planning/root_correction.h"
#include "core/planning/segment_search.h"
#include "core/planning/synthesis.h"

namespace motiondb::core {
namespace {

// As in the paper: layer 13 of 16.
constexpr double kCoarseShare = 0.8;
constexpr double kAimMargin = 0.02;  // m of extra clearance at the end
constexpr int kMaxAttempts = 3;      // to reach the goal on the given body

class Planner {
 public:
  Planner(const Model& model, const MarkerScheme& scheme, const PlanProblem& problem,
          const PlanControl& control, int layer, std::vector<PlanOrigin> origins, Body body)
      : model_(model),
        scheme_(scheme),
        problem_(problem),
        control_(control),
        layer_(layer),
        origins_(std::move(origins)),
        body_(std::move(body)),
        floor_(model, body_.leg_length_m(), problem.playable.mask.get()),
        aim_(Aim(problem)) {}

  absl::StatusOr<PlanAnswer> Plan() {
    answer_.leg_length_m = body_.leg_length_m();
    if (std::string reason = WhyUnreachable(); !reason.empty()) {
      if (control_.search_over) control_.search_over();
      answer_.effort.complete = true;
      answer_.missing = std::move(reason);
      return std::move(answer_);
    }
    MOTIONDB_RETURN_IF_ERROR(problem_.method == PlanMethod::kSegmentSearch ? PlanBySegments()
                                                                           : PlanBySampling());
    SetOutcome();
    return std::move(answer_);
  }

 private:
  // Returns a reason why no search can succeed; empty if there is none.
  std::string WhyUnreachable() const {
    const FloorPose& goal = problem_.goal;
    const double clearance = problem_.obstacles.clearance_m;
    const auto too_near = [&](std::string_view what, double distance) {
      return distance < 0 ? fmt::format("the {} is inside an obstacle", what)
                          : fmt::format("the {} is {:.3g} m from an obstacle, expected {:.3g}",
                                        what, distance, clearance);
    };
    const double goal_distance = Distance(problem_.obstacles, {goal.x, goal.y});
    if (goal_distance + problem_.position_tolerance_m < clearance) {
      return too_near("goal", goal_distance);
    }
    const double start_distance = Distance(problem_.obstacles, {0, 0});
    if (start_distance < clearance) return too_near("start", start_distance);
    const double reach = floor_.top_speed_m_s() * problem_.max_duration_seconds;
    const double distance_m = std::hypot(goal.x, goal.y);
    if (distance_m - problem_.position_tolerance_m > reach) {
      return fmt::format(
          "the goal is {:.2f} m away, the fastest stored motion covers {:.2f} m in {:.3g} s",
          distance_m, reach, problem_.max_duration_seconds);
    }
    const double turn = std::abs(WrapAngle(goal.heading));
    const double max_turn = floor_.top_turn_rad_s() * problem_.max_duration_seconds;
    if (turn - problem_.heading_tolerance_rad > max_turn) {
      return fmt::format(
          "the goal's heading differs by {:.2f} rad, the fastest stored motion turns {:.2f} rad in "
          "{:.3g} s",
          turn, max_turn, problem_.max_duration_seconds);
    }
    return {};
  }

  // Returns the goal, or, if it is too near an obstacle, the nearest clear position within its
  // tolerance.
  static FloorPose Aim(const PlanProblem& problem) {
    const auto is_clear = [&](const FloorPose& pose) {
      return Distance(problem.obstacles, {pose.x, pose.y}) >=
             problem.obstacles.clearance_m + kAimMargin;
    };
    constexpr int kRings = 8;
    constexpr int kBearings = 32;
    for (int ring = 0; ring <= kRings; ++ring) {
      const double away = problem.position_tolerance_m * ring / (kRings + 1);
      for (int i = 0; i < kBearings; ++i) {
        const double bearing = 2 * std::numbers::pi * i / kBearings;
        const FloorPose aim{problem.goal.x + away * std::cos(bearing),
                            problem.goal.y + away * std::sin(bearing), problem.goal.heading};
        if (is_clear(aim)) return aim;
      }
    }
    return problem.goal;
  }

  SearchSettings Settings() const {
    const double moved = std::hypot(aim_.x - problem_.goal.x, aim_.y - problem_.goal.y);
    return {.goal = aim_,
            .position_tolerance_m = std::max(0.0, problem_.position_tolerance_m - moved),
            .heading_tolerance_rad = problem_.heading_tolerance_rad,
            .max_duration_seconds = problem_.max_duration_seconds,
            .frame_rate_hz = model_.settings().frame_rate_hz,
            .path_count = 1 + problem_.alternative_count,
            .seed = problem_.seed,
            .effort = problem_.effort};
  }

  absl::Status PlanBySegments() {
    const FloorField field(problem_.obstacles, {0, 0}, {aim_.x, aim_.y});
    if (!std::isfinite(field.DistanceToGoal({0, 0}))) {
      if (control_.search_over) control_.search_over();
      answer_.effort.complete = true;
      answer_.missing = "the obstacles block every path to the goal";
      return absl::OkStatus();
    }
    FoundPaths found;
    MOTIONDB_RETURN_IF_ERROR(SearchFromOrigins(
        SegmentGraph(model_, floor_, layer_, problem_.playable, Similarity::kSimilar), field,
        found));
    if (!found.reached && !time_up_) {
      // Nodes of a layer half way up contain more frames that are roughly similar.
      MOTIONDB_RETURN_IF_ERROR(
          SearchFromOrigins(SegmentGraph(model_, floor_, (layer_ + 1) / 2, problem_.playable,
                                         Similarity::kRoughlySimilar),
                            field, found));
    }
    if (control_.search_over) control_.search_over();
    for (const FoundPath& path : found.paths) {
      // Always synthesise the first; skip others rather than miss a deadline.
      if (!answer_.motions.empty() && TimeUp()) break;
      MOTIONDB_RETURN_IF_ERROR(AddSegments(path.path));
    }
    return absl::OkStatus();
  }

  // Searches from each origin until one leads to the goal. Updates `best` if the goal is reached or
  // the path ends nearer.
  absl::Status SearchFromOrigins(SegmentGraph graph, const FloorField& field, FoundPaths& best) {
    const SearchSettings settings = Settings();
    answer_.effort.complete = true;
    for (std::size_t i = 0; i < origins_.size() && !best.reached && !time_up_; ++i) {
      MOTIONDB_ASSIGN_OR_RETURN(FoundPaths found,
                                SearchSegments(graph, floor_, origins_[i].frame, problem_.obstacles,
                                               field, settings, control_));
      answer_.effort.expansions += found.effort.expansions;
      answer_.effort.improvements += found.effort.improvements;
      answer_.effort.complete = answer_.effort.complete && found.effort.complete;
      time_up_ = found.time_up;
      const bool nearer =
          !found.paths.empty() &&
          (best.paths.empty() || found.paths[0].violation < best.paths[0].violation);
      if (found.reached || nearer) {
        best = std::move(found);
        origin_ = i;
      }
    }
    reached_ = best.reached;
    return absl::OkStatus();
  }

  absl::Status AddSegments(const SplicedPath& path) {
    PlannedMotion planned;
    planned.coarse_layer = layer_;
    for (int first = path.start; const Join& join : path.joins) {
      planned.segments.push_back({first, join.leave});
      first = join.enter + 1;
    }
    planned.segments.push_back(
        {path.joins.empty() ? path.start : path.joins.back().enter + 1, path.end});
    for (const PlayedFrame& frame : PlayedFrames(path)) {
      planned.coarse_nodes.push_back(model_.tree().node_of_frame(layer_, frame.main));
    }
    const std::vector<FloorPose> root = PlayedRoot(floor_, path);
    FloorPose aim = aim_;
    std::optional<PlannedMotion> best;
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      PlannedMotion aimed = planned;
      MOTIONDB_RETURN_IF_ERROR(Play(path, CorrectRoot(root, aim), aimed));
      // A body of other proportions ends slightly beside its markers' end: shift the aim
      // accordingly.
      const Eigen::Index last = aimed.root.rows() - 1;
      aim.x += aim_.x - aimed.root(last, 0);
      aim.y += aim_.y - aimed.root(last, 1);
      aim.heading += WrapAngle(aim_.heading - aimed.root(last, 2));
      if (!best || Lack(aimed) < Lack(*best)) best = std::move(aimed);
      // A motion that is cut would need another path, not another aim.
      if (best->outcome == PlanOutcome::kExact || best->cut || TimeUp()) break;
    }
    return Add(*std::move(best));
  }

  absl::Status Add(PlannedMotion motion) {
    if (motion.joints && problem_.dynamics && problem_.dynamics->has_masses()) {
      motion.forces =
          MeasureForces(body_, *problem_.dynamics, *motion.joints, motion.markers, motion.contacts);
    }
    MOTIONDB_RETURN_IF_ERROR(MeasureExtrapolation(model_, scheme_.set, problem_.playable.mask,
                                                  body_.leg_length_m(), control_.cancelled,
                                                  motion));
    answer_.motions.push_back(std::move(motion));
    return absl::OkStatus();
  }

  bool TimeUp() const { return control_.time_up && control_.time_up(); }

  // Returns the sum of the violations of clearance and tolerances.
  double Lack(const PlannedMotion& motion) const {
    const double clearance =
        motion.quality.smallest_clearance_m.value_or(problem_.obstacles.clearance_m);
    return std::max(0.0, problem_.obstacles.clearance_m - clearance) +
           std::max(0.0, motion.quality.position_error_m - problem_.position_tolerance_m) +
           std::max(0.0, motion.quality.heading_error_rad - problem_.heading_tolerance_rad);
  }

  absl::Status Play(const SplicedPath& path, const CorrectedRoot& root, PlannedMotion& planned) {
    planned.quality.correction_m = root.largest_shift_m;
    planned.quality.correction_heading_rad = root.turn_rad;
    const SynthesisedMotion motion = Synthesise(model_, body_, origins_[origin_], path, root.poses);
    MOTIONDB_ASSIGN_OR_RETURN(planned.bottom_nodes, BottomNodes(motion.markers));
    return RetargetToBody(scheme_, body_, problem_, motion, control_.cancelled, planned);
  }

  // Returns the node path (section IV-A) of the motion itself.
  absl::StatusOr<std::vector<std::int32_t>> BottomNodes(const MarkerMotion& markers) const {
    MOTIONDB_ASSIGN_OR_RETURN(StateSequence states,
                              ComputeStates(scheme_.set, markers, body_.leg_length_m()));
    model_.scale().Apply(states.states);
    MOTIONDB_ASSIGN_OR_RETURN(
        PathSearch search,
        FindNodePaths(model_, states.states, {.mask = problem_.playable.mask}, control_.cancelled));
    return std::move(search.paths.front().nodes);
  }

  absl::Status PlanBySampling() {
    const SearchSettings settings = Settings();
    MOTIONDB_ASSIGN_OR_RETURN(
        SampledPaths sampled,
        SampleWalks(model_, layer_, origins_.front().frame, problem_.playable, body_.leg_length_m(),
                    problem_.obstacles, settings, control_));
    answer_.effort = sampled.effort;
    time_up_ = sampled.time_up;
    reached_ = sampled.reached;
    for (SampledPath& path : sampled.paths) MOTIONDB_RETURN_IF_ERROR(AddMeans(std::move(path)));
    return absl::OkStatus();
  }

  // Adds the paper's motion: the sequence of the bottom nodes' mean positions.
  absl::Status AddMeans(SampledPath path) {
    SynthesisedMotion motion;
    motion.markers.names = model_.marker_set().markers;
    motion.markers.frame_rate_hz = model_.settings().frame_rate_hz;
    motion.markers.positions_m =
        MeanPositions(model_, path.bottom_nodes, path.root, body_.leg_length_m());
    motion.contacts = DetectContacts(body_.stored_feet(), motion.markers.positions_m,
                                     motion.markers.frame_rate_hz, body_.leg_length_m());
    body_.Fit(motion.markers.positions_m);
    PlannedMotion planned;
    planned.coarse_layer = layer_;
    planned.coarse_nodes = std::move(path.coarse_nodes);
    planned.bottom_nodes = std::move(path.bottom_nodes);
    MOTIONDB_RETURN_IF_ERROR(
        RetargetToBody(scheme_, body_, problem_, motion, control_.cancelled, planned));
    return Add(std::move(planned));
  }

  // Sorts the motions, best first, and sets the overall outcome.
  void SetOutcome() {
    std::stable_sort(answer_.motions.begin(), answer_.motions.end(),
                     [](const PlannedMotion& a, const PlannedMotion& b) {
                       return a.outcome == PlanOutcome::kExact && b.outcome != PlanOutcome::kExact;
                     });
    if (!answer_.motions.empty() && answer_.motions.front().outcome == PlanOutcome::kExact) {
      answer_.outcome = PlanOutcome::kExact;
      return;
    }
    if (!answer_.motions.empty()) {
      answer_.missing = answer_.motions.front().missing;
    } else if (answer_.missing.empty()) {
      answer_.missing = "no stored motion continues from the start";
    }
    if (time_up_ && !reached_) {
      answer_.outcome = PlanOutcome::kDeadline;
    } else if (answer_.effort.complete && !reached_) {
      answer_.outcome = PlanOutcome::kUnreachable;
      if (!answer_.motions.empty()) answer_.missing += "; the search was exhaustive";
    } else {
      answer_.outcome = PlanOutcome::kApproximate;
    }
  }

  const Model& model_;
  const MarkerScheme& scheme_;
  const PlanProblem& problem_;
  const PlanControl& control_;
  const int layer_;
  const std::vector<PlanOrigin> origins_;
  std::size_t origin_ = 0;  // the origin in use
  const Body body_;
  const StoredFloor floor_;
  const FloorPose aim_;
  PlanAnswer answer_;
  bool time_up_ = false;
  bool reached_ = false;  // according to the search
};

absl::StatusOr<Body> BodyFor(const Model& model, const MarkerScheme& scheme,
                             const PlanProblem& problem, const PlanOrigin& origin) {
  if (problem.skeleton)
    return Body::OfSkeleton(model, scheme, problem.skeleton, problem.flat_soles);
  return Body::OfSize(model, problem.leg_length_m.value_or(origin.leg_length_m));
}

}  // namespace

absl::StatusOr<PlanAnswer> PlanMotion(const Model& model, const MarkerScheme& scheme,
                                      const PlanProblem& problem, const PlanControl& control) {
  MOTIONDB_RETURN_IF_ERROR(CheckProblem(model, problem));
  int layer = std::max(1, static_cast<int>(std::lround(kCoarseShare * model.layer_count())));
  if (problem.coarse_layer != 0) {
    MOTIONDB_ASSIGN_OR_RETURN(layer, model.ResolveLayer(problem.coarse_layer));
  }
  MOTIONDB_ASSIGN_OR_RETURN(std::vector<PlanOrigin> origins,
                            FindOrigins(model, problem.start, problem.playable));
  if (problem.max_joint_acceleration && !problem.skeleton) {
    return FieldViolation("max_joint_acceleration",
                          "expected a skeleton or a robot as the body, got markers only");
  }
  MOTIONDB_ASSIGN_OR_RETURN(Body body, BodyFor(model, scheme, problem, origins.front()));
  return Planner(model, scheme, problem, control, layer, std::move(origins), std::move(body))
      .Plan();
}

}  // namespace motiondb::core
