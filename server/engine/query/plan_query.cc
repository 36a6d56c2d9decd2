#include "server/engine/query/plan_query.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/error.h"
#include "core/planning/synthesis.h"
#include "server/engine/query/query_memory.h"

namespace motiondb::server {
namespace {

constexpr double kMaxSearchSeconds = 60;

absl::Status CheckSearchTime(double seconds) {
  if (seconds > 0 && seconds <= kMaxSearchSeconds) return absl::OkStatus();
  return core::FieldViolation("search_timeout", "expected more than 0 s and at most {} s, got {} s",
                              kMaxSearchSeconds, seconds);
}

// Maps core's error to the request field that caused it.
absl::Status AtStart(const core::PlanStart& start, const absl::Status& status) {
  const std::string message(status.message());
  if (absl::IsNotFound(status)) {
    return core::WithReason("CLIP_NOT_FOUND", core::FieldViolation("clip_start.clip", message));
  }
  if (absl::IsOutOfRange(status)) return core::FieldViolation("clip_start.seconds", message);
  return start.observation ? core::AtField("observation_start", status) : status;
}

// Adds the fields that determine the memory of a plan to the error of a reservation.
absl::Status WithLimits(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return status;
  absl::Status named = absl::ResourceExhaustedError(
      fmt::format("{} (reduce max_duration_seconds, frame_rate_hz or alternative_count)",
                  std::string(status.message())));
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { named.SetPayload(url, payload); });
  return named;
}

}  // namespace

absl::StatusOr<PreparedPlan> PreparePlan(const Query& query, const PlanRequest& request) {
  MOTIONDB_RETURN_IF_ERROR(CheckSearchTime(request.max_search_seconds));
  if (request.file_format) {
    MOTIONDB_RETURN_IF_ERROR(CheckWrittenFormat("file_format", *request.file_format));
  }
  PreparedPlan plan{.problem = request.problem};
  core::PlanProblem& problem = plan.problem;
  problem.playable.mask = query.mask();
  MOTIONDB_RETURN_IF_ERROR(core::CheckProblem(query.model(), problem));
  // The effort, not the clock, ends most searches, so that the same request returns the same plan.
  problem.effort = 1 + std::max(0.0, request.max_search_seconds - kDefaultSearchSeconds);
  if (request.observation_start) {
    MOTIONDB_ASSIGN_OR_RETURN(problem.start.observation, query.States(*request.observation_start));
  }
  const auto origins = core::FindOrigins(query.model(), problem.start, problem.playable);
  if (!origins.ok()) return AtStart(problem.start, origins.status());
  const auto& clips = query.model().clips();
  const std::string start_clip =
      problem.start.clip ? problem.start.clip->clip
                         : clips[query.model().clip_of_frame(origins->front().frame)].id;
  MOTIONDB_ASSIGN_OR_RETURN(const auto scheme, query.database()->scheme());
  MOTIONDB_ASSIGN_OR_RETURN(plan.body, FindBody(query, request, start_clip, *scheme));
  problem.skeleton = plan.body.skeleton;
  problem.flat_soles = plan.body.is_robot;
  problem.dynamics = plan.body.dynamics;
  return plan;
}

absl::StatusOr<std::vector<ExportedMotion>> WriteMotions(const core::PlanAnswer& answer,
                                                         const PlanBody& body,
                                                         std::optional<core::FileFormat> format,
                                                         const core::Cancelled& cancelled) {
  const core::FileFormat written =
      format.value_or(body.is_robot ? core::FileFormat::kCsv : core::FileFormat::kBvh);
  const bool has_table = written == core::FileFormat::kCsv && body.is_robot;
  core::Mimics mimics;
  if (has_table) mimics = body.mimics;
  std::vector<ExportedMotion> files;
  for (const core::PlannedMotion& motion : answer.motions) {
    if (cancelled && cancelled()) return absl::CancelledError("the call was cancelled");
    const bool with_joints = motion.joints && (has_table || core::HasJoints(written));
    MOTIONDB_ASSIGN_OR_RETURN(
        core::WrittenMotion file,
        core::WriteMotion(written,
                          with_joints ? core::Motion(*motion.joints) : core::Motion(motion.markers),
                          mimics));
    const std::string stem = files.empty() ? "plan" : fmt::format("plan-{}", files.size() + 1);
    files.push_back({stem + std::string(core::WrittenExtension(written)), std::move(file.bytes),
                     std::move(file.losses)});
  }
  return files;
}

absl::StatusOr<PlanResult> FindPlan(const Query& query, const PlanRequest& request) {
  MOTIONDB_ASSIGN_OR_RETURN(PreparedPlan plan, PreparePlan(query, request));
  const WorkOptions& terms = query.terms();
  MOTIONDB_RETURN_IF_ERROR(WithLimits(terms.Reserve(BytesToPlan(query.model(), plan.problem))));
  SearchClock clock(request.max_search_seconds, terms.deadline);
  const core::PlanControl control{.cancelled = terms.cancelled,
                                  .time_up = [&] { return clock.time_up(); },
                                  .search_over = [&] { clock.EndSearch(); }};
  PlanResult result;
  MOTIONDB_ASSIGN_OR_RETURN(
      result.answer, core::PlanMotion(query.model(), plan.body.scheme, plan.problem, control));
  MOTIONDB_RETURN_IF_ERROR(
      WithLimits(terms.Reserve(BytesOfPlan(result.answer, request.with_files))));
  if (request.with_files) {
    MOTIONDB_ASSIGN_OR_RETURN(
        result.files, WriteMotions(result.answer, plan.body, request.file_format, terms.cancelled));
  }
  result.body = std::move(plan.body);
  result.search_seconds = clock.search_seconds();
  result.total_seconds = clock.total_seconds();
  return result;
}

namespace {

constexpr double kSearchShare = 0.5;  // share of the time until the deadline

double Seconds(std::chrono::duration<double> time) { return time.count(); }

}  // namespace

SearchClock::SearchClock(double limit_seconds, std::chrono::system_clock::time_point deadline) {
  // In seconds: the deadline of a call without one would overflow the clock's ticks.
  const double remaining = Seconds(deadline.time_since_epoch()) -
                           Seconds(std::chrono::system_clock::now().time_since_epoch());
  const double allowed = std::min(limit_seconds, std::max(0.0, kSearchShare * remaining));
  search_end_ =
      start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(allowed));
}

double SearchClock::search_seconds() const {
  return Seconds(std::min(Clock::now(), search_end_seen_) - start_);
}

double SearchClock::total_seconds() const { return Seconds(Clock::now() - start_); }

}  // namespace motiondb::server
