#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/inference/node_path.h"
#include "core/model/model.h"
#include "core/motion/error.h"
#include "core/planning/body.h"
#include "core/planning/goal.h"
#include "core/planning/motion_quality.h"
#include "core/planning/plan.h"
#include "core/planning/random_sampling.h"
#include "core/planning/segment_search.h"
#include "core/planning/synthesis.h"

namespace motiondb::core {
namespace {

// As in the paper: layer 13 of 16.
constexpr double kCoarseShare = 0.8;
constexpr int kMaxAttempts = 3;            // to reach the goal on the given body, with one path
constexpr std::uint32_t kMaxSearches = 6;  // for a path on which the body reaches the goal

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
        aim_(AimFor(problem)) {}

  absl::StatusOr<PlanAnswer> Plan() {
    answer_.leg_length_m = body_.leg_length_m();
    if (std::string reason = WhyUnreachable(problem_, floor_); !reason.empty()) {
      if (control_.search_over) control_.search_over();
      answer_.effort.complete = true;
      answer_.missing = std::move(reason);
      return std::move(answer_);
    }
    MOTIONDB_RETURN_IF_ERROR(problem_.method == PlanMethod::kSegmentSearch ? PlanBySegments()
                                                                           : PlanBySampling());
    SetOutcome();
    MOTIONDB_RETURN_IF_ERROR(Measure());
    return std::move(answer_);
  }

 private:
  SearchSettings Settings(const FloorPose& goal) const {
    const double moved = std::hypot(aim_.x - problem_.goal.x, aim_.y - problem_.goal.y);
    return {.goal = goal,
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
    std::optional<SegmentGraph> graph;
    graph.emplace(model_, floor_, layer_, problem_.playable, Similarity::kSimilar);
    MOTIONDB_RETURN_IF_ERROR(SearchFromOrigins(*graph, field, Settings(aim_), found));
    if (!found.reached && !time_up_) {
      // Nodes of a layer half way up contain more frames that are roughly similar.
      graph.emplace(model_, floor_, (layer_ + 1) / 2, problem_.playable,
                    Similarity::kRoughlySimilar);
      MOTIONDB_RETURN_IF_ERROR(SearchFromOrigins(*graph, field, Settings(aim_), found));
    }
    reached_ = found.reached;
    if (control_.search_over) control_.search_over();
    FloorPose beside;
    MOTIONDB_ASSIGN_OR_RETURN(answer_.motions, PlayPaths(found, beside));
    return reached_ ? SearchForBody(*graph, beside) : absl::OkStatus();
  }

  // While the body ends further beside its paths than a correction covers, searches for other paths
  // that end as far on the other side of the goal. `beside`: see PlayPaths.
  absl::Status SearchForBody(SegmentGraph& graph, FloorPose beside) {
    for (std::uint32_t search = 1; search < kMaxSearches && MissesGoal(); ++search) {
      SearchSettings settings = Settings(Opposite(beside));
      settings.seed += search;  // other costs lead to other paths
      const FloorField field(problem_.obstacles, {0, 0}, {settings.goal.x, settings.goal.y});
      FoundPaths found;
      MOTIONDB_RETURN_IF_ERROR(SearchFromOrigins(graph, field, settings, found));
      if (!found.reached) break;
      MOTIONDB_ASSIGN_OR_RETURN(std::vector<PlannedMotion> motions, PlayPaths(found, beside));
      if (SmallestLack(motions) < SmallestLack(answer_.motions)) {
        answer_.motions = std::move(motions);
      }
    }
    return absl::OkStatus();
  }

  // Whether no motion is exact, but one on another path may be.
  bool MissesGoal() const {
    const auto is_settled = [](const PlannedMotion& motion) {
      return motion.outcome == PlanOutcome::kExact || motion.cut;
    };
    return !TimeUp() && std::ranges::none_of(answer_.motions, is_settled);
  }

  // Searches from each origin until one leads to the goal. Updates `best` if the goal is reached or
  // the path ends nearer.
  absl::Status SearchFromOrigins(SegmentGraph& graph, const FloorField& field,
                                 const SearchSettings& settings, FoundPaths& best) {
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
    return absl::OkStatus();
  }

  // Returns a motion for each path. `beside`: the expected end of the body relative to the end of
  // its path; set to that of the first motion.
  absl::StatusOr<std::vector<PlannedMotion>> PlayPaths(const FoundPaths& found, FloorPose& beside) {
    std::vector<PlannedMotion> motions;
    const FloorPose expected = beside;
    for (const FoundPath& path : found.paths) {
      // Always synthesise the first of all; skip others rather than miss a deadline.
      if (!(motions.empty() && answer_.motions.empty()) && TimeUp()) break;
      FloorPose of_path = expected;
      MOTIONDB_ASSIGN_OR_RETURN(PlannedMotion motion, PlaySegments(path.path, of_path));
      if (motions.empty()) beside = of_path;
      motions.push_back(std::move(motion));
    }
    return motions;
  }

  // Returns the pose from which a body that ends `beside` it reaches the aim.
  FloorPose Opposite(const FloorPose& beside) const {
    return {aim_.x - beside.x, aim_.y - beside.y, aim_.heading - beside.heading};
  }

  // Returns the best motion of a few aims. `beside`: see PlayPaths.
  absl::StatusOr<PlannedMotion> PlaySegments(const SplicedPath& path, FloorPose& beside) {
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
    std::optional<PlannedMotion> best;
    for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
      // A body of other proportions ends slightly beside its markers' end.
      const CorrectedRoot corrected = CorrectRoot(root, Opposite(beside));
      PlannedMotion aimed = planned;
      MOTIONDB_RETURN_IF_ERROR(Play(path, corrected, aimed));
      const FloorPose& end = corrected.poses.back();
      const auto reached = aimed.root.row(aimed.root.rows() - 1);
      beside = {reached[0] - end.x, reached[1] - end.y, WrapAngle(reached[2] - end.heading)};
      if (!best || Lack(aimed) < Lack(*best)) best = std::move(aimed);
      // A motion that is cut would need another path, not another aim.
      if (best->outcome == PlanOutcome::kExact || best->cut || TimeUp()) break;
      const GoalError rest =
          ErrorAfterCorrection(root.back(), corrected.length_m, Opposite(beside));
      if (rest.position_m > problem_.position_tolerance_m ||
          rest.heading_rad > problem_.heading_tolerance_rad) {
        break;
      }
    }
    return *std::move(best);
  }

  // Completes what is reported of each motion.
  absl::Status Measure() {
    for (PlannedMotion& motion : answer_.motions) {
      if (motion.joints && problem_.dynamics && problem_.dynamics->has_masses()) {
        motion.forces = MeasureForces(body_, *problem_.dynamics, *motion.joints, motion.markers,
                                      motion.contacts);
      }
      MOTIONDB_RETURN_IF_ERROR(MeasureExtrapolation(model_, scheme_.set, problem_.playable.mask,
                                                    body_.leg_length_m(), control_.cancelled,
                                                    motion));
    }
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

  double SmallestLack(const std::vector<PlannedMotion>& motions) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const PlannedMotion& motion : motions) smallest = std::min(smallest, Lack(motion));
    return smallest;
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
    const SearchSettings settings = Settings(aim_);
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
    answer_.motions.push_back(std::move(planned));
    return absl::OkStatus();
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
  if (problem.coarse_layer) {
    MOTIONDB_ASSIGN_OR_RETURN(layer, model.ResolveLayer(*problem.coarse_layer));
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
