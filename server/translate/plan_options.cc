#include "server/translate/plan_options.h"

#include <algorithm>
#include <set>

#include "core/motion/error.h"
#include "core/planning/start.h"
#include "motiondb/v1/plan.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/numbers.h"
#include "server/translate/observation.h"
#include "server/translate/obstacles.h"
#include "server/translate/resource_name.h"

namespace motiondb::server {
namespace {

constexpr double kFarthestGoalM = 1000;
constexpr double kLongestMotionSeconds = 120;
constexpr double kLongestSearchSeconds = 60;
constexpr int kMostAlternatives = 10;
constexpr double kLowestFrameRateHz = 1;
constexpr double kHighestFrameRateHz = 1000;
// Of all motions of an answer, which is one message: ten alternatives of 120 s at 120 Hz are
// 158,400.
constexpr double kMostFrames = 200'000;
constexpr std::size_t kShownLabels = 10;

absl::StatusOr<core::FloorPose> GoalFrom(const v1::PlanRequest& request) {
  if (!request.has_goal()) return FieldViolation("goal", "is missing");
  const v1::FloorPose& goal = request.goal();
  core::FloorPose pose;
  MOTIONDB_ASSIGN_OR_RETURN(pose.x,
                            Between("goal.x_m", goal.x_m(), -kFarthestGoalM, kFarthestGoalM));
  MOTIONDB_ASSIGN_OR_RETURN(pose.y,
                            Between("goal.y_m", goal.y_m(), -kFarthestGoalM, kFarthestGoalM));
  MOTIONDB_ASSIGN_OR_RETURN(pose.heading, Finite("goal.heading_rad", goal.heading_rad()));
  return pose;
}

// 0 means `fallback`.
absl::StatusOr<double> SecondsFrom(std::string_view field, double value, double fallback,
                                   double most) {
  MOTIONDB_ASSIGN_OR_RETURN(const double seconds, Between(field, value, 0, most));
  return seconds > 0 ? seconds : fallback;
}

absl::Status SetNumbers(const v1::PlanRequest& request, const core::Model& model,
                        PlanOptions& options) {
  core::PlanProblem& problem = options.problem;
  MOTIONDB_ASSIGN_OR_RETURN(problem.goal, GoalFrom(request));
  if (request.has_position_tolerance_m()) {
    MOTIONDB_ASSIGN_OR_RETURN(problem.position_tolerance_m,
                              NotNegative("position_tolerance_m", request.position_tolerance_m()));
  }
  if (request.has_heading_tolerance_rad()) {
    MOTIONDB_ASSIGN_OR_RETURN(
        problem.heading_tolerance_rad,
        NotNegative("heading_tolerance_rad", request.heading_tolerance_rad()));
  }
  MOTIONDB_ASSIGN_OR_RETURN(problem.max_duration_seconds,
                            SecondsFrom("max_duration_seconds", request.max_duration_seconds(),
                                        problem.max_duration_seconds, kLongestMotionSeconds));
  MOTIONDB_ASSIGN_OR_RETURN(options.max_search_seconds,
                            SecondsFrom("max_search_seconds", request.max_search_seconds(),
                                        options.max_search_seconds, kLongestSearchSeconds));
  // The effort, not the clock, ends most searches, so that the same request gives the same plan.
  problem.effort = 1 + std::max(0.0, options.max_search_seconds - kUsualSearchSeconds);
  MOTIONDB_ASSIGN_OR_RETURN(
      problem.coarse_layer,
      IntegerBetween("coarse_layer", request.coarse_layer(), 0, model.layer_count()));
  MOTIONDB_ASSIGN_OR_RETURN(
      const int alternatives,
      IntegerBetween("alternative_count", request.alternative_count(), 0, kMostAlternatives));
  problem.plan_count = 1 + alternatives;
  if (request.frame_rate_hz() != 0) {
    MOTIONDB_ASSIGN_OR_RETURN(
        problem.frame_rate_hz,
        Between("frame_rate_hz", request.frame_rate_hz(), kLowestFrameRateHz, kHighestFrameRateHz));
  }
  const double rate =
      problem.frame_rate_hz > 0 ? problem.frame_rate_hz : model.settings().frame_rate_hz;
  const double frames = rate * problem.max_duration_seconds * problem.plan_count;
  if (frames > kMostFrames) {
    return FieldViolation(
        "frame_rate_hz",
        "expected at most {} frames in all, got {} motions of up to {} s at {} Hz: ask for fewer "
        "or shorter ones, or a lower rate",
        kMostFrames, problem.plan_count, problem.max_duration_seconds, rate);
  }
  problem.seed = request.seed();
  problem.respect_joint_limits = !request.ignore_joint_limits();
  return absl::OkStatus();
}

absl::StatusOr<core::PlanMethod> MethodFrom(v1::PlanMethod method) {
  switch (method) {
    case v1::PLAN_METHOD_UNSPECIFIED:
    case v1::PLAN_METHOD_SEGMENT_SEARCH:
      return core::PlanMethod::kSegmentSearch;
    case v1::PLAN_METHOD_RANDOM_SAMPLING:
      return core::PlanMethod::kRandomSampling;
    default:
      return FieldViolation("method", "{} is no way to search", static_cast<int>(method));
  }
}

absl::StatusOr<std::vector<std::string>> LabelsFrom(const v1::PlanRequest& request,
                                                    const core::Model& model) {
  std::set<std::string> known;
  for (const core::ModelClip& clip : model.clips()) known.insert(clip.label);
  for (int i = 0; i < request.labels_size(); ++i) {
    if (known.contains(request.labels(i))) continue;
    const bool few = known.size() <= kShownLabels;
    return FieldViolation(
        fmt::format("labels[{}]", i), "no clip of the model has the label '{}'; it has {}",
        request.labels(i),
        few ? fmt::format("{}", fmt::join(known, ", ")) : fmt::format("{} others", known.size()));
  }
  return std::vector<std::string>(request.labels().begin(), request.labels().end());
}

absl::StatusOr<core::PlanStart> StartFrom(const v1::PlanRequest& request, Engine& engine,
                                          const LiveDatabase& database, const WorkTerms& terms) {
  core::PlanStart start;
  if (request.has_clip_start()) {
    const v1::ClipMoment& moment = request.clip_start();
    MOTIONDB_ASSIGN_OR_RETURN(const MemberId clip, ParseClipName("clip_start.clip", moment.clip()));
    if (clip.database != database.name()) {
      return FieldViolation("clip_start.clip", "expected a clip of databases/{}, got '{}'",
                            database.name(), moment.clip());
    }
    MOTIONDB_ASSIGN_OR_RETURN(const double seconds,
                              NotNegative("clip_start.seconds", moment.seconds()));
    start.clip = core::ClipMoment{clip.id, seconds};
  } else if (request.has_observation_start()) {
    MOTIONDB_ASSIGN_OR_RETURN(
        start.observation,
        StatesFrom("observation_start", request.observation_start(), engine, database,
                   {Allowed::kAllWork, terms.cancelled, terms.reserve}));  // a plan is heavy itself
  }
  return start;
}

// core's error at the field that caused it.
absl::Status AtStart(const core::PlanStart& start, const absl::Status& status) {
  const std::string message(status.message());
  if (absl::IsNotFound(status)) return FieldViolation("clip_start.clip", message);
  if (absl::IsOutOfRange(status)) return FieldViolation("clip_start.seconds", message);
  return start.observation ? AtField("observation_start", status) : status;
}

}  // namespace

absl::StatusOr<PlanOptions> OptionsFrom(const v1::PlanRequest& request, const core::Model& model,
                                        Engine& engine, const LiveDatabase& database,
                                        const WorkTerms& terms) {
  PlanOptions options;
  core::PlanProblem& problem = options.problem;
  MOTIONDB_RETURN_IF_ERROR(SetNumbers(request, model, options));
  MOTIONDB_ASSIGN_OR_RETURN(problem.method, MethodFrom(request.method()));
  MOTIONDB_ASSIGN_OR_RETURN(problem.labels, LabelsFrom(request, model));
  MOTIONDB_ASSIGN_OR_RETURN(problem.obstacles, ObstaclesFrom("obstacles", request.obstacles()));
  MOTIONDB_ASSIGN_OR_RETURN(problem.start, StartFrom(request, engine, database, terms));
  const auto origins = core::FindOrigins(model, problem.start, problem.labels);
  if (!origins.ok()) return AtStart(problem.start, origins.status());
  options.start_clip = problem.start.clip
                           ? problem.start.clip->clip
                           : model.clips()[model.clip_of_frame(origins->front().frame)].id;
  return options;
}

}  // namespace motiondb::server
