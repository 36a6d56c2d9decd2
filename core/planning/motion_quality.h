// Quality of planned motion: sliding or sinking feet, jerk, and how far it is from stored motion:
// blending, the correction of its end, slowing and another body change stored frames.
#pragma once

#include <memory>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

class ClipMask;
class Model;
struct PlannedMotion;

// Differences between frames grow with the frame rate if motion is rough: compare values of equal
// frame rates only.
struct MotionQuality {
  // Distance (cm) that feet in contact slide on the floor per second of contact of one foot. In
  // each step, it is the smallest displacement of the foot's standing markers: rolling, or turning
  // about a point of the foot, is not sliding.
  double foot_slide_cm_per_s = 0;
  // Maximum depth (cm) of a contact marker below its rest height, in any frame.
  double floor_penetration_cm = 0;
  // Third differences of positions: rms over markers, peak over frames.
  double peak_marker_jerk_m_s3 = 0;
  // Rotation speed of each joint relative to its parent, and its second differences, peak over
  // joints and frames; 0 without a skeleton. Not the rates of single angles, which are unbounded
  // near gimbal lock.
  double peak_joint_speed_rad_s = 0;
  double peak_joint_jerk_rad_s3 = 0;
};

// `contacts`: of the frames of `markers` (see contacts.h). leg_length_m: the subject's. `joints`,
// if not null, has the same frames. Ignores missing markers (NaN).
MotionQuality MeasureQuality(const Feet& feet, const MarkerMotion& markers,
                             const ContactMatrix& contacts, double leg_length_m,
                             const JointMotion* joints);

// Sets PlanQuality::unknown of a motion whose markers are complete. Recognizes windows of 0.4 s
// every 0.1 s among the clips that `mask` allows (null: all). CANCELLED.
absl::Status MeasureExtrapolation(const Model& model, const MarkerSet& set,
                                  std::shared_ptr<const ClipMask> mask, double leg_length_m,
                                  const Cancelled& cancelled, PlannedMotion& motion);

}  // namespace motiondb::core
