#include "server/translate/plan_message.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/view/clip_picture.h"
#include "motiondb/v1/plan.pb.h"
#include "server/translate/file_format.h"
#include "server/translate/message_fields.h"
#include "server/translate/model_message.h"
#include "server/translate/observation_message.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {

namespace {

v1::PlanOutcome ToProto(core::PlanOutcome outcome) {
  switch (outcome) {
    case core::PlanOutcome::kExact:
      return v1::PLAN_OUTCOME_EXACT;
    case core::PlanOutcome::kApproximate:
      return v1::PLAN_OUTCOME_APPROXIMATE;
    case core::PlanOutcome::kUnreachable:
      return v1::PLAN_OUTCOME_UNREACHABLE;
    case core::PlanOutcome::kDeadline:
      return v1::PLAN_OUTCOME_DEADLINE;
  }
  return v1::PLAN_OUTCOME_UNSPECIFIED;
}

void SetSegments(const core::PlannedMotion& motion, const std::string& database,
                 const core::Model& model, v1::PlannedMotion& message) {
  const double rate = model.settings().frame_rate_hz;
  for (const core::PlayedSegment& segment : motion.segments) {
    const core::ModelClip& clip = model.clips()[model.clip_of_frame(segment.first_frame)];
    v1::PlayedSegment& to = *message.add_segments();
    to.set_clip(ClipName(database, clip.id));
    to.set_start_seconds((segment.first_frame - clip.first_frame) / rate);
    to.set_end_seconds((segment.last_frame - clip.first_frame) / rate);
  }
}

void SetQuality(const core::PlanQuality& quality, v1::PlanQuality& message) {
  message.set_position_error_m(quality.position_error_m);
  message.set_heading_error_rad(quality.heading_error_rad);
  message.set_length_m(quality.length_m);
  message.set_duration_seconds(quality.duration_seconds);
  message.set_correction_m(quality.correction_m);
  message.set_correction_heading_rad(quality.correction_heading_rad);
  message.set_foot_slide_m_per_s(quality.motion.foot_slide_cm_per_s / 100);
  message.set_floor_penetration_m(quality.motion.floor_penetration_cm / 100);
  message.set_peak_marker_jerk_m_s3(quality.motion.peak_marker_jerk_m_s3);
  message.set_peak_joint_speed_rad_s(quality.motion.peak_joint_speed_rad_s);
  message.set_peak_joint_jerk_rad_s3(quality.motion.peak_joint_jerk_rad_s3);
  if (quality.smallest_clearance_m) message.set_smallest_clearance_m(*quality.smallest_clearance_m);
  message.set_joint_limit_violations(quality.joint_limit_violations);
  message.set_marker_fit_rms_m(quality.marker_fit_rms_m);
  message.set_joint_speed_violations(quality.rate_violations.speeds);
  message.set_joint_acceleration_violations(quality.rate_violations.accelerations);
  message.set_stored_duration_seconds(quality.recorded_seconds);
  if (quality.unknown) {
    message.set_unknown_probability(quality.unknown->probability);
    message.set_unknown_at_seconds(quality.unknown->seconds);
  }
}

// Sets what joint limits do to the motion, and the efforts that it needs. REQUIRES: the message has
// its dof_names.
void SetLimits(const core::PlannedMotion& motion, const core::RobotDynamics* dynamics,
               v1::PlannedMotion& message) {
  for (const core::SlowedPart& part : motion.slowed) {
    v1::SlowedPart& to = *message.add_slowed_parts();
    to.set_start_seconds(part.start_seconds);
    to.set_end_seconds(part.end_seconds);
    to.set_dof_name(message.dof_names(part.limit.coordinate));
    to.set_limit(part.limit.kind == core::LimitKind::kSpeed ? v1::JOINT_LIMIT_SPEED
                                                            : v1::JOINT_LIMIT_ACCELERATION);
    to.set_factor(part.factor);
  }
  if (!motion.forces) return;
  for (const core::PeakEffort& peak : motion.forces->efforts) {
    v1::JointEffort& to = *message.add_joint_efforts();
    to.set_dof_name(message.dof_names(peak.coordinate));
    to.set_peak_effort(peak.effort);
    to.set_at_seconds(peak.seconds);
    const double limit = dynamics->max_efforts[peak.coordinate];
    if (std::isfinite(limit)) to.set_effort_limit(limit);
  }
  if (const auto& balance = motion.forces->balance) {
    v1::Balance& to = *message.mutable_balance();
    to.set_smallest_margin_m(balance->smallest_margin_m);
    to.set_at_seconds(balance->seconds);
    to.set_outside_seconds(balance->outside_seconds);
    to.set_supported_seconds(balance->supported_seconds);
  }
}

void SetFrames(const core::PlannedMotion& motion, std::span<const core::LinkVisual> visuals,
               v1::PlannedMotion& message) {
  message.set_frame_rate_hz(motion.markers.frame_rate_hz);
  message.set_frame_count(static_cast<int>(motion.root.rows()));
  for (Eigen::Index frame = 0; frame < motion.root.rows(); ++frame) {
    v1::FloorPose& pose = *message.add_root();
    pose.set_x_m(motion.root(frame, 0));
    pose.set_y_m(motion.root(frame, 1));
    pose.set_heading_rad(motion.root(frame, 2));
  }
  for (const std::string& name : motion.markers.names)
    message.add_marker_names(text::ValidUtf8(name));
  const core::FrameMatrix& positions = motion.markers.positions_m;
  AppendPacked(positions.data(), static_cast<std::size_t>(positions.size()),
               *message.mutable_marker_positions());
  if (!motion.joints) return;
  for (const std::string& name : DofNames(*motion.joints->skeleton)) {
    message.add_dof_names(text::ValidUtf8(name));
  }
  const core::FrameMatrix angles = motion.joints->angles.cast<float>();
  AppendPacked(angles.data(), static_cast<std::size_t>(angles.size()),
               *message.mutable_joint_angles());
  const core::Skeleton& skeleton = *motion.joints->skeleton;
  for (const core::Joint& joint : skeleton.joints()) {
    message.add_joint_names(text::ValidUtf8(joint.name));
  }
  AddBones(core::JointBones(skeleton), *message.mutable_joint_bones());
  const core::FrameMatrix joints = core::JointPositions(*motion.joints);
  AppendPacked(joints.data(), static_cast<std::size_t>(joints.size()),
               *message.mutable_joint_positions());
  if (visuals.empty()) return;
  AddVisuals(visuals, *message.mutable_joint_visuals());
  const core::FrameMatrix rotations = core::JointRotations(*motion.joints);
  AppendPacked(rotations.data(), static_cast<std::size_t>(rotations.size()),
               *message.mutable_joint_rotations());
}

void SetFile(ExportedMotion file, v1::MotionFile& message) {
  *message.mutable_data() = std::move(file.bytes);
  for (const std::string& note : file.notes) message.add_notes(text::ValidUtf8(note));
  message.set_file_name(std::move(file.file_name));
}

}  // namespace

void SetPlan(PlanResult plan, const std::string& database, const core::Model& model,
             v1::PlanResponse& message) {
  const core::PlanAnswer& answer = plan.answer;
  message.set_outcome(ToProto(answer.outcome));
  message.set_missing(text::ValidUtf8(answer.missing));
  message.set_leg_length_m(answer.leg_length_m);
  if (!plan.body.skeleton_id.empty()) {
    message.set_skeleton(SkeletonName(database, plan.body.skeleton_id));
  }
  v1::SearchEffort& effort = *message.mutable_effort();
  effort.set_expansions(answer.effort.expansions);
  effort.set_improvements(answer.effort.improvements);
  effort.set_complete(answer.effort.complete);
  effort.set_search_seconds(plan.search_seconds);
  effort.set_total_seconds(plan.total_seconds);
  for (std::size_t i = 0; i < answer.motions.size(); ++i) {
    const core::PlannedMotion& motion = answer.motions[i];
    v1::PlannedMotion& to = i == 0 ? *message.mutable_motion() : *message.add_alternatives();
    to.set_outcome(ToProto(motion.outcome));
    to.set_missing(text::ValidUtf8(motion.missing));
    SetSegments(motion, database, model, to);
    to.set_coarse_layer(motion.coarse_layer);
    to.mutable_coarse_node_ids()->Add(motion.coarse_nodes.begin(), motion.coarse_nodes.end());
    to.mutable_bottom_node_ids()->Add(motion.bottom_nodes.begin(), motion.bottom_nodes.end());
    SetFrames(motion, plan.body.visuals, to);
    SetQuality(motion.quality, *to.mutable_quality());
    SetLimits(motion, plan.body.dynamics.get(), to);
    if (i < plan.files.size()) SetFile(std::move(plan.files[i]), *to.mutable_file());
  }
}

namespace {

// Returns the movement of a degree of freedom and its axis: "tx", "rz".
std::string Movement(const core::Dof& dof) {
  Eigen::Index axis = 0;
  dof.axis.cwiseAbs().maxCoeff(&axis);
  return {dof.kind == core::Dof::Kind::kTranslation ? 't' : 'r', "xyz"[axis]};
}

}  // namespace

std::vector<std::string> DofNames(const core::Skeleton& skeleton) {
  std::vector<std::string> names;
  for (const core::Joint& joint : skeleton.joints()) {
    if (joint.dofs.size() == 1) {
      names.push_back(joint.name);
      continue;
    }
    std::map<std::string, int> seen;
    for (const core::Dof& dof : joint.dofs) {
      const std::string movement = Movement(dof);
      const int count = ++seen[movement];
      names.push_back(fmt::format("{}.{}", joint.name, movement));
      if (count > 1) names.back() += std::to_string(count);
    }
  }
  return names;
}

namespace {

absl::StatusOr<core::FloorPose> GoalFrom(const v1::PlanRequest& request) {
  if (!request.has_goal()) return FieldViolation("goal", "is missing");
  const v1::FloorPose& goal = request.goal();
  return core::FloorPose{goal.x_m(), goal.y_m(), goal.heading_rad()};
}

absl::StatusOr<core::PlanMethod> PlanMethodFrom(v1::PlanMethod method) {
  switch (method) {
    case v1::PLAN_METHOD_UNSPECIFIED:
    case v1::PLAN_METHOD_SEGMENT_SEARCH:
      return core::PlanMethod::kSegmentSearch;
    case v1::PLAN_METHOD_RANDOM_SAMPLING:
      return core::PlanMethod::kRandomSampling;
    default:
      return FieldViolation("method",
                            "unknown method {}; expected segment search or random sampling",
                            static_cast<int>(method));
  }
}

Eigen::Vector2d PointFrom(const v1::FloorPoint& point) { return {point.x_m(), point.y_m()}; }

absl::StatusOr<core::Obstacles> ObstaclesFrom(const v1::Obstacles& message) {
  core::Obstacles obstacles;
  for (const v1::Disc& disc : message.discs()) {
    if (!disc.has_centre()) {
      return FieldViolation(fmt::format("obstacles.discs[{}].centre", obstacles.discs.size()),
                            "is missing");
    }
    obstacles.discs.push_back({PointFrom(disc.centre()), disc.radius_m()});
  }
  for (const v1::Polygon& polygon : message.polygons()) {
    auto& corners = obstacles.polygons.emplace_back().corners;
    for (const v1::FloorPoint& corner : polygon.corners()) corners.push_back(PointFrom(corner));
  }
  if (message.has_clearance_m()) obstacles.clearance_m = message.clearance_m();
  return obstacles;
}

void SetNumbers(const v1::PlanRequest& request, PlanRequest& plan) {
  core::PlanProblem& problem = plan.problem;
  if (request.has_position_tolerance_m()) {
    problem.position_tolerance_m = request.position_tolerance_m();
  }
  if (request.has_heading_tolerance_rad()) {
    problem.heading_tolerance_rad = request.heading_tolerance_rad();
  }
  if (request.has_max_duration_seconds()) {
    problem.max_duration_seconds = request.max_duration_seconds();
  }
  if (request.has_search_timeout()) {
    const auto& timeout = request.search_timeout();
    plan.max_search_seconds = static_cast<double>(timeout.seconds()) + 1e-9 * timeout.nanos();
  }
  if (request.has_coarse_layer()) problem.coarse_layer = request.coarse_layer();
  problem.alternative_count = request.alternative_count();
  if (request.has_frame_rate_hz()) problem.frame_rate_hz = request.frame_rate_hz();
  problem.seed = request.seed();
  problem.respect_joint_limits = !request.ignore_joint_limits();
  if (request.has_speed_limit_scale()) problem.speed_limit_scale = request.speed_limit_scale();
  if (request.has_max_joint_acceleration()) {
    problem.max_joint_acceleration = request.max_joint_acceleration();
  }
}

absl::Status SetStart(const v1::PlanRequest& request, const std::string& database,
                      PlanRequest& plan) {
  if (request.has_clip_start()) {
    const v1::ClipMoment& moment = request.clip_start();
    MOTIONDB_ASSIGN_OR_RETURN(std::string clip,
                              IdIn(database, "clip_start.clip", "clip", moment.clip(),
                                   ParseClipName("clip_start.clip", moment.clip())));
    plan.problem.start.clip = core::ClipMoment{std::move(clip), moment.seconds()};
  } else if (request.has_observation_start()) {
    MOTIONDB_ASSIGN_OR_RETURN(
        plan.observation_start,
        ParseObservation("observation_start", request.observation_start(), database));
  }
  return absl::OkStatus();
}

absl::Status SetBody(const v1::PlanRequest& request, const std::string& database,
                     PlanRequest& plan) {
  if (request.has_robot()) {
    plan.body = core::SourceFile{request.robot().file_name(), request.robot().urdf()};
  } else if (request.body_case() == v1::PlanRequest::kSkeleton) {
    MOTIONDB_ASSIGN_OR_RETURN(plan.body, IdIn(database, "skeleton", "skeleton", request.skeleton(),
                                              ParseSkeletonName("skeleton", request.skeleton())));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<PlanRequest> ParsePlanRequest(const v1::PlanRequest& request,
                                             const std::string& database) {
  PlanRequest plan;
  MOTIONDB_ASSIGN_OR_RETURN(plan.problem.goal, GoalFrom(request));
  SetNumbers(request, plan);
  MOTIONDB_ASSIGN_OR_RETURN(plan.problem.method, PlanMethodFrom(request.method()));
  plan.problem.playable.labels = {request.labels().begin(), request.labels().end()};
  MOTIONDB_ASSIGN_OR_RETURN(plan.problem.obstacles, ObstaclesFrom(request.obstacles()));
  MOTIONDB_RETURN_IF_ERROR(SetStart(request, database, plan));
  MOTIONDB_RETURN_IF_ERROR(SetBody(request, database, plan));
  plan.with_files = request.include_files();
  if (request.file_format() != v1::FILE_FORMAT_UNSPECIFIED) {
    MOTIONDB_ASSIGN_OR_RETURN(plan.file_format, ParseFormat("file_format", request.file_format()));
  }
  return plan;
}

}  // namespace motiondb::server
