// A plan, from what is asked for to core's answer: the start, the body that is to play it, and the
// time that the search may take. Safe to call from any thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/format/urdf_reader.h"
#include "core/planning/plan.h"
#include "server/engine/query.h"

namespace motiondb::server {

// Far more than the usual effort takes: a slow machine's plans are those of a fast one.
inline constexpr double kUsualSearchSeconds = 5;

// What a plan is asked for. Refers to what the caller sent, which must outlive it.
struct PlanRequest {
  core::PlanProblem problem;  // without a body
  std::optional<Observation> observation_start;
  // Who plays it: whoever is in the clip that the plan begins in or is most like, a skeleton of the
  // database by its id, or a robot by its URDF.
  std::variant<std::monostate, std::string, core::SourceFile> body;
  double max_search_seconds = kUsualSearchSeconds;
  bool with_files = false;  // each motion as a file, too: there has to be a body
};

struct PlanBody {
  std::shared_ptr<const core::Skeleton> skeleton;  // null: bare markers
  bool is_robot = false;
  std::vector<core::MimicJoint> mimics;  // of a robot
};

// All that core's search needs.
struct PreparedPlan {
  core::PlanProblem problem;
  std::shared_ptr<const core::MarkerScheme> scheme;
  PlanBody body;
};

struct PlanResult {
  core::PlanAnswer answer;
  PlanBody body;
  double search_seconds = 0;
  double total_seconds = 0;
};

// Finds the start and the body. INVALID_ARGUMENT names the field that is out of range, unknown or
// does not fit; NOT_FOUND for the skeleton of an observation's joints; FAILED_PRECONDITION where
// files are wanted and there is no body to write; CANCELLED.
absl::StatusOr<PreparedPlan> PreparePlan(const Query& query, const PlanRequest& request);

// Prepares a plan and searches for it. Codes also RESOURCE_EXHAUSTED.
absl::StatusOr<PlanResult> FindPlan(const Query& query, const PlanRequest& request);

// The body that `request` names, or else that of the clip `start_clip`; bare markers where that
// clip has none. Codes as PreparePlan.
absl::StatusOr<PlanBody> FindBody(const Query& query, const PlanRequest& request,
                                  const std::string& start_clip, const core::MarkerScheme& scheme);

}  // namespace motiondb::server
