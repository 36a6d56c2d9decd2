#include "server/translate/plan_message.h"

#include "core/format/bvh_writer.h"
#include "core/format/joint_table_writer.h"
#include "core/motion/error.h"
#include "motiondb/v1/plan.pb.h"
#include "server/translate/dof_names.h"
#include "server/translate/packed_floats.h"
#include "server/translate/resource_name.h"
#include "text/utf8.h"

namespace motiondb::server {
namespace {

v1::PlanOutcome ToProto(core::PlanOutcome outcome) {
  switch (outcome) {
    case core::PlanOutcome::kExact:
      return v1::EXACT;
    case core::PlanOutcome::kApproximate:
      return v1::APPROXIMATE;
    case core::PlanOutcome::kUnreachable:
      return v1::UNREACHABLE;
    case core::PlanOutcome::kDeadline:
      return v1::DEADLINE;
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
  message.set_foot_slide_cm_per_s(quality.motion.foot_slide_cm_per_s);
  message.set_floor_penetration_cm(quality.motion.floor_penetration_cm);
  message.set_peak_marker_jerk_m_s3(quality.motion.peak_marker_jerk_m_s3);
  message.set_peak_joint_speed_rad_s(quality.motion.peak_joint_speed_rad_s);
  message.set_peak_joint_jerk_rad_s3(quality.motion.peak_joint_jerk_rad_s3);
  if (quality.smallest_clearance_m) message.set_smallest_clearance_m(*quality.smallest_clearance_m);
  message.set_joint_limit_violations(quality.joint_limit_violations);
  message.set_marker_fit_rms_m(quality.marker_fit_rms_m);
}

void SetFrames(const core::PlannedMotion& motion, v1::PlannedMotion& message) {
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
}

// `number` counts the motions of an answer from 1.
absl::Status SetFile(const core::JointMotion& joints, const PlanBody& body, int number,
                     v1::MotionFile& message) {
  const std::string stem = number == 1 ? "plan" : fmt::format("plan-{}", number);
  if (body.is_robot) {
    MOTIONDB_ASSIGN_OR_RETURN(*message.mutable_data(), core::WriteJointTable(joints, body.mimics));
    message.set_file_name(stem + ".csv");
    return absl::OkStatus();
  }
  MOTIONDB_ASSIGN_OR_RETURN(*message.mutable_data(), core::WriteBvh(joints));
  message.set_file_name(stem + ".bvh");
  return absl::OkStatus();
}

}  // namespace

absl::Status SetPlan(const core::PlanAnswer& answer, const std::string& database,
                     const core::Model& model, const PlanBody& body, bool with_files,
                     const core::Cancelled& cancelled, v1::PlanResponse& message) {
  message.set_outcome(ToProto(answer.outcome));
  message.set_missing(text::ValidUtf8(answer.missing));
  message.set_leg_length_m(answer.leg_length_m);
  v1::SearchEffort& effort = *message.mutable_effort();
  effort.set_expansions(answer.effort.expansions);
  effort.set_improvements(answer.effort.improvements);
  effort.set_complete(answer.effort.complete);
  int number = 0;
  for (const core::PlannedMotion& motion : answer.motions) {
    if (cancelled()) return absl::CancelledError("nobody waits for the plan");
    v1::PlannedMotion& to = ++number == 1 ? *message.mutable_motion() : *message.add_alternatives();
    to.set_outcome(ToProto(motion.outcome));
    to.set_missing(text::ValidUtf8(motion.missing));
    SetSegments(motion, database, model, to);
    to.set_coarse_layer(motion.coarse_layer);
    to.mutable_coarse_node_ids()->Add(motion.coarse_nodes.begin(), motion.coarse_nodes.end());
    to.mutable_bottom_node_ids()->Add(motion.bottom_nodes.begin(), motion.bottom_nodes.end());
    SetFrames(motion, to);
    SetQuality(motion.quality, *to.mutable_quality());
    if (!with_files || !motion.joints) continue;
    MOTIONDB_RETURN_IF_ERROR(SetFile(*motion.joints, body, number, *to.mutable_file()));
  }
  return absl::OkStatus();
}

}  // namespace motiondb::server
