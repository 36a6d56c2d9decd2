// Quality of synthesised motion: sliding or sinking feet, and jerk.
#pragma once

#include "core/motion/motion.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

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

}  // namespace motiondb::core
