// Skeletons of the SMPL family of body models: joints in the models' own order, and mean
// proportions.
//
// Names, order and parents are those of the public `smplx` package and of the AMASS archives.
//   SMPL    24 joints  22 of the body, then left and right hand
//   SMPL-H  52 joints  22 of the body, then 15 of the left and 15 of the right hand: three joints
//                      for each of index, middle, pinky, ring, thumb
//   SMPL-X  55 joints  22 of the body, jaw, left and right eye, then the hands as in SMPL-H
//
// The models themselves, with the shape of each subject, are under a licence and not part of
// motiondb. Rest positions are derived from published anthropometry, as fractions of the stature H:
//   Drillis and Contini (Body Segment Parameters, New York University 1966), as quoted in Winter,
//   Biomechanics and Motor Control of Human Movement: heights of the hip 0.530, knee 0.285, ankle
//   0.039, shoulder 0.818 and eye 0.936; upper arm 0.186, forearm 0.146, hand 0.108, foot length
//   0.152.
// Their table has no joint centres inside the trunk and no widths between joint centres, so these
// are choices of this project, within the outer breadths of the table (hips 0.191, shoulders
// 0.259): hips 0.05 and shoulders 0.10 from the middle, the division of the spine, joints inside
// hand, foot and head.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

namespace motiondb::importer {

enum class SmplModel { kSmpl, kSmplH, kSmplX };
enum class SmplGender { kNeutral, kFemale, kMale };

struct SmplJoint {
  std::string_view name;
  int parent = -1;  // precedes the joint; -1 for the pelvis
  // Position in the T-pose, in statures, above the middle of the soles: x to the left, y up, z to
  // the front.
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
};

// "SMPL", "SMPL-H", "SMPL-X".
std::string_view NameOf(SmplModel model);
// "male", ...
std::string_view NameOf(SmplGender gender);

// Returns the joints in the order of the model's pose parameters.
std::vector<SmplJoint> SmplJoints(SmplModel model);

// Returns the stature (m) that stands for all subjects: 1.75 for men, 1.62 for women, and 1.69,
// about the mean of both, if the gender is unknown.
double SmplStature(SmplGender gender);

// Returns the pelvis in the model's own frame (m), in which `trans` is a translation: models rotate
// about the pelvis, but their origin is in the chest, so that the pelvis in the world is at
// trans + SmplPelvis, whatever its orientation. About 0.22 m below the origin in SMPL and SMPL-H,
// 0.35 m in SMPL-X; the exact value depends on the licensed model and the subject's shape.
Eigen::Vector3d SmplPelvis(SmplModel model);

}  // namespace motiondb::importer
