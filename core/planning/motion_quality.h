// What a viewer sees first in synthesised motion: feet that slide or sink, and jerks. Safe to call
// from any thread.
#pragma once

#include "core/motion/motion.h"
#include "core/planning/contacts.h"

namespace motiondb::core {

// Differences from frame to frame grow with the frame rate where motion is rough: compare figures
// of one rate only.
struct MotionQuality {
  // Way (cm) that feet in contact travel on the floor, for each second of contact of one foot. From
  // one frame to the next a foot travels as far as that of its standing markers that moves least:
  // a foot that rolls or turns about a point of it does not slide.
  double foot_slide_cm_per_s = 0;
  // Deepest that a contact marker goes below its height at rest (cm), in any frame.
  double floor_penetration_cm = 0;
  // Third differences of positions: root mean square over markers, peak over frames.
  double peak_marker_jerk_m_s3 = 0;
  // How fast each joint turns against its parent, about whatever axis, and how that changes (second
  // differences), peak over joints and frames; 0 without a skeleton. Not the rates of single
  // angles: those of a joint with three grow without bound near gimbal lock, though nothing moves
  // fast.
  double peak_joint_speed_rad_s = 0;
  double peak_joint_jerk_rad_s3 = 0;
};

// `contacts` are those of the frames of `markers` (see contacts.h), leg_length_m the subject's.
// `joints`, where given, has the same frames. Missing markers (NaN) are passed over.
MotionQuality MeasureQuality(const Feet& feet, const MarkerMotion& markers,
                             const ContactMatrix& contacts, double leg_length_m,
                             const JointMotion* joints);

}  // namespace motiondb::core
