// Skeletons of the CMU data in its conversions and of other data sets; names and
// hierarchies as published. Test data; format in skeleton_conventions.h.
// Conventions: cmu_acclaim_asf, cmu_cgspeed_motionbuilder, cmu_cgspeed_max,
// cmu_cgspeed_max_simplified, cmu_cgspeed_daz, lafan1, 100style, bandai_namco, truebones_human,
// accad, fairmotion_27, human36m_32_repeated_names, human36m_without_sites.
#include <string_view>

#include "tests/core/mapping/conventions/skeleton_conventions.h"

namespace motiondb::tests {

std::string_view CmuAndResearchConventions() {
  static constexpr std::string_view kTable = R"(
convention cmu_acclaim_asf
# Also HDM05. Site of a bone: its start. The wrist bone (pronation) starts along the forearm.
kind joints
root - pelvis
lhipjoint root pelvis
lfemur lhipjoint l_hip
ltibia lfemur l_knee
lfoot ltibia l_ankle
ltoes lfoot l_toe
rhipjoint root pelvis
rfemur rhipjoint r_hip
rtibia rfemur r_knee
rfoot rtibia r_ankle
rtoes rfoot r_toe
lowerback root pelvis
upperback lowerback spine:0.33
thorax upperback spine:0.67
lowerneck thorax neck
upperneck lowerneck between:neck:head:0.5
head upperneck head
lclavicle thorax l_clavicle
lhumerus lclavicle l_shoulder
lradius lhumerus l_elbow
lwrist lradius between:l_elbow:l_wrist:0.67
lhand lwrist l_wrist
lfingers lhand l_hand
lthumb lwrist l_finger:1:1
rclavicle thorax r_clavicle
rhumerus rclavicle r_shoulder
rradius rhumerus r_elbow
rwrist rradius between:r_elbow:r_wrist:0.67
rhand rwrist r_wrist
rfingers rhand r_hand
rthumb rwrist r_finger:1:1

convention cmu_cgspeed_motionbuilder
# In these files Neck lies upon Spine1, and FingerBase and Thumb upon Hand.
kind joints
Hips - pelvis
LHipJoint Hips pelvis
LeftUpLeg LHipJoint l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
RHipJoint Hips pelvis
RightUpLeg RHipJoint r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
LowerBack Hips pelvis
Spine LowerBack spine:0.5
Spine1 Spine spine:1
Neck Spine1 neck
Neck1 Neck between:neck:head:0.5
Head Neck1 head
LeftShoulder Spine1 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftFingerBase LeftHand l_wrist
LeftHandIndex1 LeftFingerBase l_hand
LThumb LeftHand l_finger:1:1
RightShoulder Spine1 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightFingerBase RightHand r_wrist
RightHandIndex1 RightFingerBase r_hand
RThumb RightHand r_finger:1:1

convention cmu_cgspeed_max
kind joints
Hips - pelvis
LHipJoint Hips pelvis
LeftHip LHipJoint l_hip
LeftKnee LeftHip l_knee
LeftAnkle LeftKnee l_ankle
LeftToe LeftAnkle l_toe
RHipJoint Hips pelvis
RightHip RHipJoint r_hip
RightKnee RightHip r_knee
RightAnkle RightKnee r_ankle
RightToe RightAnkle r_toe
lowerback Hips pelvis
Chest lowerback spine:0.5
Chest2 Chest spine:1
lowerneck Chest2 neck
Neck lowerneck between:neck:head:0.5
Head Neck head
LeftCollar Chest2 l_clavicle
LeftShoulder LeftCollar l_shoulder
LeftElbow LeftShoulder l_elbow
LeftWrist LeftElbow l_wrist
lhand LeftWrist l_wrist
LFingers lhand l_hand
LThumb LeftWrist l_finger:1:1
RightCollar Chest2 r_clavicle
RightShoulder RightCollar r_shoulder
RightElbow RightShoulder r_elbow
RightWrist RightElbow r_wrist
rhand RightWrist r_wrist
RFingers rhand r_hand
RThumb RightWrist r_finger:1:1

convention cmu_cgspeed_max_simplified
kind joints
Hips - pelvis
LeftHip Hips l_hip
LeftKnee LeftHip l_knee
LeftAnkle LeftKnee l_ankle
LeftToe LeftAnkle l_toe
RightHip Hips r_hip
RightKnee RightHip r_knee
RightAnkle RightKnee r_ankle
RightToe RightAnkle r_toe
Chest Hips spine:0.3
Chest2 Chest spine:0.65
LeftCollar Chest2 l_clavicle
LeftShoulder LeftCollar l_shoulder
LeftElbow LeftShoulder l_elbow
LeftWrist LeftElbow l_wrist
RightCollar Chest2 r_clavicle
RightShoulder RightCollar r_shoulder
RightElbow RightShoulder r_elbow
RightWrist RightElbow r_wrist
Neck Chest2 neck
Head Neck head

convention cmu_cgspeed_daz
# In these files Buttock lies 2 to 3 cm from Thigh.
kind joints
hip - pelvis
abdomen hip spine:0.38
chest abdomen spine:0.59
neck chest neck
head neck head
leftEye head l_eye
rightEye head r_eye
rCollar chest r_clavicle
rShldr rCollar r_shoulder
rForeArm rShldr r_elbow
rHand rForeArm r_wrist
rThumb1 rHand r_finger:1:1
rThumb2 rThumb1 r_finger:1:2
rIndex1 rHand r_finger:2:1
rIndex2 rIndex1 r_finger:2:2
rMid1 rHand r_finger:3:1
rMid2 rMid1 r_finger:3:2
rRing1 rHand r_finger:4:1
rRing2 rRing1 r_finger:4:2
rPinky1 rHand r_finger:5:1
rPinky2 rPinky1 r_finger:5:2
lCollar chest l_clavicle
lShldr lCollar l_shoulder
lForeArm lShldr l_elbow
lHand lForeArm l_wrist
lThumb1 lHand l_finger:1:1
lThumb2 lThumb1 l_finger:1:2
lIndex1 lHand l_finger:2:1
lIndex2 lIndex1 l_finger:2:2
lMid1 lHand l_finger:3:1
lMid2 lMid1 l_finger:3:2
lRing1 lHand l_finger:4:1
lRing2 lRing1 l_finger:4:2
lPinky1 lHand l_finger:5:1
lPinky2 lPinky1 l_finger:5:2
rButtock hip r_buttock
rThigh rButtock r_hip
rShin rThigh r_knee
rFoot rShin r_ankle
lButtock hip l_buttock
lThigh lButtock l_hip
lShin lThigh l_knee
lFoot lShin l_ankle

convention lafan1
kind joints
Hips - pelvis
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToe LeftFoot l_toe
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToe RightFoot r_toe
Spine Hips spine:0.15
Spine1 Spine spine:0.4
Spine2 Spine1 spine:0.65
Neck Spine2 neck
Head Neck head
LeftShoulder Spine2 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
RightShoulder Spine2 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist

convention 100style
# The names of the BVH export of Xsens MVN.
kind joints
Hips - pelvis
Chest Hips spine:0.18
Chest2 Chest spine:0.37
Chest3 Chest2 spine:0.55
Chest4 Chest3 spine:0.72
Neck Chest4 neck
Head Neck head
RightCollar Chest4 r_clavicle
RightShoulder RightCollar r_shoulder
RightElbow RightShoulder r_elbow
RightWrist RightElbow r_wrist
LeftCollar Chest4 l_clavicle
LeftShoulder LeftCollar l_shoulder
LeftElbow LeftShoulder l_elbow
LeftWrist LeftElbow l_wrist
RightHip Hips r_hip
RightKnee RightHip r_knee
RightAnkle RightKnee r_ankle
RightToe RightAnkle r_toe
LeftHip Hips l_hip
LeftKnee LeftHip l_knee
LeftAnkle LeftKnee l_ankle
LeftToe LeftAnkle l_toe

convention bandai_namco
kind joints
joint_Root - origin
Hips joint_Root pelvis
Spine Hips spine:0.15
Chest Spine spine:0.5
Neck Chest neck
Head Neck head
Shoulder_L Chest l_clavicle
UpperArm_L Shoulder_L l_shoulder
LowerArm_L UpperArm_L l_elbow
Hand_L LowerArm_L l_wrist
Shoulder_R Chest r_clavicle
UpperArm_R Shoulder_R r_shoulder
LowerArm_R UpperArm_R r_elbow
Hand_R LowerArm_R r_wrist
UpperLeg_L Hips l_hip
LowerLeg_L UpperLeg_L l_knee
Foot_L LowerLeg_L l_ankle
Toes_L Foot_L l_toe
UpperLeg_R Hips r_hip
LowerLeg_R UpperLeg_R r_knee
Foot_R LowerLeg_R r_ankle
Toes_R Foot_R r_toe

convention truebones_human
kind joints
Hips - pelvis
LeftHip Hips l_hip
LeftKnee LeftHip l_knee
LeftAnkle LeftKnee l_ankle
LeftToe LeftAnkle l_toe
RightHip Hips r_hip
RightKnee RightHip r_knee
RightAnkle RightKnee r_ankle
RightToe RightAnkle r_toe
Chest Hips spine:0.3
Neck Chest neck
Head Neck head
LeftCollar Chest l_clavicle
LeftShoulder LeftCollar l_shoulder
LeftElbow LeftShoulder l_elbow
LeftWrist LeftElbow l_wrist
RightCollar Chest r_clavicle
RightShoulder RightCollar r_shoulder
RightElbow RightShoulder r_elbow
RightWrist RightElbow r_wrist

convention accad
kind joints
Hips - pelvis
ToSpine Hips pelvis
Spine ToSpine spine:0.2
Spine1 Spine spine:0.55
Neck Spine1 neck
Head Neck head
LeftShoulder Spine1 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
RightShoulder Spine1 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe

convention fairmotion_27
kind joints
Hips - pelvis
Spine Hips spine:0.12
Spine1 Spine spine:0.27
Spine2 Spine1 spine:0.43
Spine3 Spine2 spine:0.59
Neck Spine3 neck
Head Neck head
RightShoulder Spine3 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandEnd RightHand r_hand
RightHandThumb1 RightHand r_finger:1:1
LeftShoulder Spine3 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandEnd LeftHand l_hand
LeftHandThumb1 LeftHand l_finger:1:1
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe

convention human36m_32_repeated_names
# The name Site occurs 7 times, as in the metadata of the data set; it is no parent.
kind joints
Hips - pelvis
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
Site RightToeBase r_toe_tip
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
Site LeftToeBase l_toe_tip
Spine Hips pelvis
Spine1 Spine spine:0.5
Neck Spine1 neck
Head Neck head
Site Head head_top
LeftShoulder Spine1 neck
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb LeftHand l_wrist
Site LeftHandThumb l_finger:1:4
L_Wrist_End LeftHand l_hand
Site L_Wrist_End l_hand
RightShoulder Spine1 neck
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb RightHand r_wrist
Site RightHandThumb r_finger:1:4
R_Wrist_End RightHand r_hand
Site R_Wrist_End r_hand

convention human36m_without_sites
# Shoulder lies upon Neck, HandThumb upon Hand, Spine upon Hips.
kind joints
Hips - pelvis
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
Spine Hips pelvis
Spine1 Spine spine:0.5
Neck Spine1 neck
Head Neck head
LeftShoulder Spine1 neck
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb LeftHand l_wrist
L_Wrist_End LeftHand l_hand
RightShoulder Spine1 neck
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb RightHand r_wrist
R_Wrist_End RightHand r_hand
)";
  return kTable;
}

}  // namespace motiondb::tests
