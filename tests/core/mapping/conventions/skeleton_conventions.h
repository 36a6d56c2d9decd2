// Published joint and marker names of many tools, each with its hierarchy and the place of
// each joint on a body. Tests map these skeletons by name and structure and compare the result.
//
// Format of the tables, line by line (blank lines and lines that begin with '#' mean nothing):
//   convention NAME       begins a convention
//   kind joints           a hierarchy: one root, parents before children, in the order of the file
//   kind points           labelled points without hierarchy: each parent is '-'
//   JOINT PARENT SITE     PARENT '-' for none; '~' in JOINT and PARENT stands for a space
//
// SITE is where the joint is (l_ and r_ for left and right):
//   pelvis, neck (base of the neck), head (base of the skull), head_top, nose, jaw
//   l_hip, l_knee, l_ankle, l_heel, l_toe (ball of the foot), l_toe_tip
//   l_clavicle (near the sternum), l_shoulder, l_elbow, l_wrist, l_hand (knuckles)
//   l_eye, l_ear, l_breast, l_buttock
//   spine:F               fraction F from the pelvis (0) to the base of the neck (1)
//   l_finger:K:S          K 1 thumb .. 5 little finger; S 1, 2, 3 start of the segment, 4 tip.
//                         1 is the base of the metacarpal of the thumb, the knuckle of the others.
//   between:A:B:F         fraction F from site A to site B
//   prop:l_hand           an object held
//   floor                 an extra root on the floor below the pelvis
//   origin                an extra root that never moves, at the world's origin
// Points also: l_asis, l_psis, sacrum, c7, t10, clav (top of the sternum), strn (its bottom),
//   rback, l_scapula, l_acromion, l_shoulder_back, l_upper_arm_out, l_elbow_out, l_elbow_in,
//   l_forearm_out, l_wrist_thumb, l_wrist_pinky, l_hand_in (index side), l_hand_out, l_finger_base,
//   l_thigh_out, l_knee_out, l_knee_in, l_shin_out, l_shin_front, l_ankle_out, l_ankle_in,
//   l_toe_big, l_toe_small, head_front, l_head_front, l_head_back, l_head_side, belly,
//   waist_front, waist_back, l_waist_side.
// Several joints of one convention may have the same site. Fractions are approximate.
#pragma once

#include <string_view>

namespace motiondb::tests {

std::string_view GameEngineConventions();      // game_engines.cc
std::string_view ContentToolConventions();     // content_tools.cc
std::string_view MocapSuitConventions();       // mocap_suits.cc
std::string_view CmuAndResearchConventions();  // cmu_and_research.cc
std::string_view BodyModelConventions();       // body_models.cc
std::string_view CameraConventions();          // cameras.cc
std::string_view MarkerSetConventions();       // marker_sets.cc

}  // namespace motiondb::tests
