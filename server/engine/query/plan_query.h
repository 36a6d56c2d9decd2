// Plan queries: finds the start and the body, limits the search time and calls core's planner.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/export/motion_writer.h"
#include "core/format/motion_file.h"
#include "core/format/urdf_reader.h"
#include "core/planning/plan.h"
#include "server/engine/query/export_clip.h"
#include "server/engine/query/query.h"

namespace motiondb::server {

// Far more than the usual effort takes, so that a slow machine returns the same plans as a fast
// one.
inline constexpr double kDefaultSearchSeconds = 5;

// Parameters of a plan. References the caller's data, which must outlive it.
struct PlanRequest {
  core::PlanProblem problem;  // without a body
  std::optional<Observation> observation_start;
  // The body: none given (that of the start clip, or of the clip most similar to the start), a
  // skeleton id of the database, or a robot as URDF.
  std::variant<std::monostate, std::string, core::SourceFile> body;
  double max_search_seconds = kDefaultSearchSeconds;
  bool with_files = false;  // also return each motion as a file
  // Of the files; none: BVH, or CSV for a robot. A format with joints requires a body.
  std::optional<core::FileFormat> file_format;

  bool needs_joints() const {
    return with_files && (!file_format || core::HasJoints(*file_format));
  }
};

struct PlanBody {
  std::shared_ptr<const core::Skeleton> skeleton;  // null: bare markers
  core::MarkerScheme scheme;                       // the database's, with a mapping of the skeleton
  std::string skeleton_id;                         // empty: not stored
  // Of a robot: a body read from URDF, in the request or with a stored clip.
  bool is_robot = false;
  std::vector<core::MimicJoint> mimics;
  std::shared_ptr<const core::RobotDynamics> dynamics;
  std::vector<core::LinkVisual> visuals;
};

// Input of core's search.
struct PreparedPlan {
  core::PlanProblem problem;
  PlanBody body;
};

struct PlanResult {
  core::PlanAnswer answer;
  PlanBody body;
  double search_seconds = 0;
  double total_seconds = 0;
  std::vector<ExportedMotion> files;  // of each motion, in order; empty if not requested
};

// Finds the start and the body. INVALID_ARGUMENT naming the field that is out of range, unknown or
// does not fit; NOT_FOUND for the skeleton of an observation; FAILED_PRECONDITION if files are
// requested without a body; CANCELLED.
absl::StatusOr<PreparedPlan> PreparePlan(const Query& query, const PlanRequest& request);

// Writes the motions of a plan: joint angles in a format with joints, otherwise markers. `format`:
// as PlanRequest::file_format. INVALID_ARGUMENT if it cannot express a motion; CANCELLED.
absl::StatusOr<std::vector<ExportedMotion>> WriteMotions(const core::PlanAnswer& answer,
                                                         const PlanBody& body,
                                                         std::optional<core::FileFormat> format,
                                                         const core::Cancelled& cancelled);

// Prepares a plan, searches for it, and writes the requested files. Codes as PreparePlan and
// WriteMotions; also RESOURCE_EXHAUSTED.
absl::StatusOr<PlanResult> FindPlan(const Query& query, const PlanRequest& request);

// Returns the body that `request` names, otherwise that of `start_clip`; bare markers if that clip
// has no skeleton. Codes as PreparePlan.
absl::StatusOr<PlanBody> FindBody(const Query& query, const PlanRequest& request,
                                  const std::string& start_clip, const core::MarkerScheme& scheme);

// Time limit and duration of the search for a plan. core has no clock, so the server passes this
// one. One object for each call; not thread-safe.
class SearchClock {
 public:
  // Starts now. The search ends after `limit_seconds`, or after half of the time until the call's
  // deadline. The rest is for the synthesis of the motion.
  SearchClock(double limit_seconds, std::chrono::system_clock::time_point deadline);

  bool time_up() const { return Clock::now() >= search_end_; }
  // Stops search_seconds().
  void EndSearch() { search_end_seen_ = Clock::now(); }

  // Duration of the search, since the clock started; it still grows until EndSearch.
  double search_seconds() const;
  double total_seconds() const;

 private:
  using Clock = std::chrono::steady_clock;

  const Clock::time_point start_ = Clock::now();
  Clock::time_point search_end_;
  Clock::time_point search_end_seen_ = Clock::time_point::max();
};

}  // namespace motiondb::server
