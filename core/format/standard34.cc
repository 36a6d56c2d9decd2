// The default marker set, in the marker-set file format (docs/file_formats.md). Every marker is a
// joint, a point between joints or a point just beyond one, so that skeletons, joint positions and
// optical markers all have it. Weights are chosen so that different sources of one motion yield the
// same markers.
#include <fmt/format.h>

#include "core/format/marker_set_file.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kText = R"(motiondb-marker-set 1
name standard34
marker Pelvis
marker LHip
marker RHip
marker LKnee
marker RKnee
marker LAnkle
marker RAnkle
marker LHeel
marker RHeel
marker LToe
marker RToe
marker LThigh
marker RThigh
marker LShin
marker RShin
marker Waist
marker Spine
marker Neck
marker Head
marker HeadTop
marker LClavicle
marker RClavicle
marker LShoulder
marker RShoulder
marker LUpperArm
marker RUpperArm
marker LElbow
marker RElbow
marker LForearm
marker RForearm
marker LWrist
marker RWrist
marker LHand
marker RHand
hips LHip RHip
leg LHip LKnee LAnkle
leg RHip RKnee RAnkle

# Default rules:
Pelvis = 0.5 LHip + 0.5 RHip
LThigh = 0.5 LHip + 0.5 LKnee
LShin = 0.5 LKnee + 0.5 LAnkle
LHeel = 1.37 LAnkle + -0.12 LKnee + -0.25 LToe
LClavicle = 0.5 Neck + 0.5 LShoulder
LUpperArm = 0.5 LShoulder + 0.5 LElbow
LForearm = 0.5 LElbow + 0.5 LWrist
RThigh = 0.5 RHip + 0.5 RKnee
RShin = 0.5 RKnee + 0.5 RAnkle
RHeel = 1.37 RAnkle + -0.12 RKnee + -0.25 RToe
RClavicle = 0.5 Neck + 0.5 RShoulder
RUpperArm = 0.5 RShoulder + 0.5 RElbow
RForearm = 0.5 RElbow + 0.5 RWrist

# Acclaim skeletons of the CMU and HDM05 collections. A joint is at the start of its bone.
mapping acclaim
signature lfemur rfemur ltibia rtibia lfoot rfoot ltoes rtoes upperback thorax lowerneck head head_end
signature lhumerus rhumerus lradius rradius lhand rhand lfingers rfingers
Waist = upperback
Spine = thorax
Neck = lowerneck
Head = head
HeadTop = head_end
LHip = lfemur
LKnee = ltibia
LAnkle = lfoot
LToe = ltoes
LShoulder = lhumerus
LElbow = lradius
LWrist = lhand
LHand = lfingers
RHip = rfemur
RKnee = rtibia
RAnkle = rfoot
RToe = rtoes
RShoulder = rhumerus
RElbow = rradius
RWrist = rhand
RHand = rfingers

# BVH conversions of the CMU collection, and joint positions with the same names. They lack the
# segment below the neck, so head and arms are raised by a similar segment.
mapping cmu-bvh
signature Hips LeftUpLeg RightUpLeg LeftLeg RightLeg LeftFoot RightFoot LeftToeBase RightToeBase
signature Spine Spine1 Neck Neck1 Head LeftArm RightArm LeftForeArm RightForeArm LeftHand RightHand
Waist = Spine
Spine = Spine1
Neck = Neck1
Head = 2 Head + -1 Neck1
HeadTop = 3 Head + -2 Neck1
LHip = LeftUpLeg
LKnee = LeftLeg
LAnkle = LeftFoot
LToe = LeftToeBase
LShoulder = LeftArm + Neck1 + -1 Neck
LElbow = LeftForeArm + Neck1 + -1 Neck
LWrist = 1.4 LeftHand + -0.4 LeftForeArm + Neck1 + -1 Neck
LHand = 1.65 LeftHand + -0.65 LeftForeArm + Neck1 + -1 Neck
RHip = RightUpLeg
RKnee = RightLeg
RAnkle = RightFoot
RToe = RightToeBase
RShoulder = RightArm + Neck1 + -1 Neck
RElbow = RightForeArm + Neck1 + -1 Neck
RWrist = 1.4 RightHand + -0.4 RightForeArm + Neck1 + -1 Neck
RHand = 1.65 RightHand + -0.65 RightForeArm + Neck1 + -1 Neck

# The same conversions with other names.
mapping cmu-bvh-hips
signature Hips LeftHip RightHip LeftKnee RightKnee LeftAnkle RightAnkle LeftToe RightToe Chest Chest2
signature lowerneck Neck Head LeftShoulder RightShoulder LeftElbow RightElbow LeftWrist RightWrist
Waist = Chest
Spine = Chest2
Neck = Neck
Head = 2 Head + -1 Neck
HeadTop = 3 Head + -2 Neck
LHip = LeftHip
LKnee = LeftKnee
LAnkle = LeftAnkle
LToe = LeftToe
LShoulder = LeftShoulder + Neck + -1 lowerneck
LElbow = LeftElbow + Neck + -1 lowerneck
LWrist = 1.4 LeftWrist + -0.4 LeftElbow + Neck + -1 lowerneck
LHand = 1.65 LeftWrist + -0.65 LeftElbow + Neck + -1 lowerneck
RHip = RightHip
RKnee = RightKnee
RAnkle = RightAnkle
RToe = RightToe
RShoulder = RightShoulder + Neck + -1 lowerneck
RElbow = RightElbow + Neck + -1 lowerneck
RWrist = 1.4 RightWrist + -0.4 RightElbow + Neck + -1 lowerneck
RHand = 1.65 RightWrist + -0.65 RightElbow + Neck + -1 lowerneck

# The DAZ-friendly BVH conversion of the CMU collection. All subjects have one skeleton, whose joints
# are those of a character: the spine is farther in front, the shoulders are lower and narrower, and
# elbows and wrists are farther in front.
mapping daz
signature hip abdomen chest neck head leftEye rightEye lThigh rThigh lShin rShin lFoot rFoot lFoot_end rFoot_end
signature lCollar rCollar lShldr rShldr lForeArm rForeArm lHand rHand
Waist = 0.65 abdomen + 0.35 chest offset abdomen 0 0 -0.056
Spine = 0.81 chest + 0.19 neck offset chest 0 0 -0.05
Neck = 0.5 lCollar + 0.5 rCollar + 0.15 chest + -0.15 neck
Head = 1.98 head + -0.98 neck offset head 0 0 -0.099
HeadTop = 1.57 head + -0.57 neck offset head 0 0.147 -0.055
LHip = lThigh
LKnee = 0.85 lShin + 0.15 lFoot
LAnkle = 1.03 lFoot + -0.03 lShin
LToe = lFoot_end
LShoulder = 1.46 lShldr + -0.17 rShldr + -0.29 chest
LUpperArm = 0.51 lForeArm + 1 lShldr + -0.22 rShldr + -0.29 chest offset lShldr 0 -0.031 -0.003
LElbow = 1.02 lForeArm + 0.49 lShldr + -0.23 rShldr + -0.28 chest offset lShldr 0 -0.045 -0.005
LForearm = 0.53 lHand + 0.5 lForeArm + 0.48 lShldr + -0.22 rShldr + -0.29 chest offset lForeArm 0 -0.065 -0.043
LWrist = 1.17 lHand + -0.15 lForeArm + 0.48 lShldr + -0.22 rShldr + -0.28 chest offset lForeArm 0 -0.094 -0.098
LHand = 1.29 lHand + -0.26 lForeArm + 0.42 lShldr + -0.19 rShldr + -0.26 chest offset lForeArm 0 -0.073 -0.109
RHip = rThigh
RKnee = 0.85 rShin + 0.15 rFoot
RAnkle = 1.03 rFoot + -0.03 rShin
RToe = rFoot_end
RShoulder = 1.46 rShldr + -0.17 lShldr + -0.29 chest
RUpperArm = 0.51 rForeArm + 1 rShldr + -0.22 lShldr + -0.29 chest offset rShldr 0 -0.031 -0.003
RElbow = 1.02 rForeArm + 0.49 rShldr + -0.23 lShldr + -0.28 chest offset rShldr 0 -0.045 -0.005
RForearm = 0.53 rHand + 0.5 rForeArm + 0.48 rShldr + -0.22 lShldr + -0.29 chest offset rForeArm 0 -0.065 -0.043
RWrist = 1.17 rHand + -0.15 rForeArm + 0.48 rShldr + -0.22 lShldr + -0.28 chest offset rForeArm 0 -0.094 -0.098
RHand = 1.29 rHand + -0.26 rForeArm + 0.42 rShldr + -0.19 lShldr + -0.26 chest offset rForeArm 0 -0.073 -0.109

# Character Creator and iClone skeletons.
mapping character-creator
signature CC_Base_L_Thigh CC_Base_R_Thigh CC_Base_L_Calf CC_Base_R_Calf CC_Base_L_Foot CC_Base_R_Foot
signature CC_Base_L_ToeBase CC_Base_R_ToeBase CC_Base_Spine01 CC_Base_Spine02 CC_Base_NeckTwist01
signature CC_Base_Head CC_Base_L_Upperarm CC_Base_R_Upperarm CC_Base_L_Forearm CC_Base_R_Forearm
signature CC_Base_L_Hand CC_Base_R_Hand
Waist = 0.3 CC_Base_Spine01 + 0.7 CC_Base_Spine02
Spine = 0.66 CC_Base_Spine02 + 0.34 CC_Base_NeckTwist01
Neck = 0.16 CC_Base_Spine02 + 0.84 CC_Base_NeckTwist01
Head = 2 CC_Base_Head + -1 CC_Base_NeckTwist01
HeadTop = 3 CC_Base_Head + -2 CC_Base_NeckTwist01
LHip = CC_Base_L_Thigh
LKnee = CC_Base_L_Calf
LAnkle = CC_Base_L_Foot
LToe = CC_Base_L_ToeBase
LShoulder = 1.12 CC_Base_L_Upperarm + -0.12 CC_Base_R_Upperarm
LElbow = CC_Base_L_Forearm + 0.12 CC_Base_L_Upperarm + -0.12 CC_Base_R_Upperarm
LWrist = 1.2 CC_Base_L_Hand + -0.2 CC_Base_L_Forearm + 0.12 CC_Base_L_Upperarm + -0.12 CC_Base_R_Upperarm
LHand = 1.4 CC_Base_L_Hand + -0.4 CC_Base_L_Forearm + 0.12 CC_Base_L_Upperarm + -0.12 CC_Base_R_Upperarm
RHip = CC_Base_R_Thigh
RKnee = CC_Base_R_Calf
RAnkle = CC_Base_R_Foot
RToe = CC_Base_R_ToeBase
RShoulder = 1.12 CC_Base_R_Upperarm + -0.12 CC_Base_L_Upperarm
RElbow = CC_Base_R_Forearm + 0.12 CC_Base_R_Upperarm + -0.12 CC_Base_L_Upperarm
RWrist = 1.2 CC_Base_R_Hand + -0.2 CC_Base_R_Forearm + 0.12 CC_Base_R_Upperarm + -0.12 CC_Base_L_Upperarm
RHand = 1.4 CC_Base_R_Hand + -0.4 CC_Base_R_Forearm + 0.12 CC_Base_R_Upperarm + -0.12 CC_Base_L_Upperarm
)";

}  // namespace

const MarkerScheme& StandardScheme() {
  static const MarkerScheme scheme =
      *ReadMarkerSetFile({"standard34", fmt::format("{}{}", kText, Standard34RobotMappings())});
  return scheme;
}

}  // namespace motiondb::core
