// Skeletons of body models; names and hierarchies as published. Test data; format in
// skeleton_conventions.h.
// Conventions: smpl, smpl_fbx, smplh, smplx, smpl_lower_case_22, kit_mmm, kit_mmm_axis_joints,
// kit_mmm_segment_joints, soma_77, soma_with_root_body_only, arkit_body.
#include <string_view>

#include "tests/core/mapping/conventions/skeleton_conventions.h"

namespace motiondb::tests {

std::string_view BodyModelConventions() {
  static constexpr std::string_view kTable = R"(
convention smpl
kind joints
Pelvis - pelvis
L_Hip Pelvis l_hip
R_Hip Pelvis r_hip
Spine1 Pelvis spine:0.22
L_Knee L_Hip l_knee
R_Knee R_Hip r_knee
Spine2 Spine1 spine:0.48
L_Ankle L_Knee l_ankle
R_Ankle R_Knee r_ankle
Spine3 Spine2 spine:0.58
L_Foot L_Ankle l_toe
R_Foot R_Ankle r_toe
Neck Spine3 neck
L_Collar Spine3 l_clavicle
R_Collar Spine3 r_clavicle
Head Neck head
L_Shoulder L_Collar l_shoulder
R_Shoulder R_Collar r_shoulder
L_Elbow L_Shoulder l_elbow
R_Elbow R_Shoulder r_elbow
L_Wrist L_Elbow l_wrist
R_Wrist R_Elbow r_wrist
L_Hand L_Wrist l_hand
R_Hand R_Wrist r_hand

convention smpl_fbx
kind joints
m_avg_root - origin
m_avg_Pelvis m_avg_root pelvis
m_avg_L_Hip m_avg_Pelvis l_hip
m_avg_R_Hip m_avg_Pelvis r_hip
m_avg_Spine1 m_avg_Pelvis spine:0.22
m_avg_L_Knee m_avg_L_Hip l_knee
m_avg_R_Knee m_avg_R_Hip r_knee
m_avg_Spine2 m_avg_Spine1 spine:0.48
m_avg_L_Ankle m_avg_L_Knee l_ankle
m_avg_R_Ankle m_avg_R_Knee r_ankle
m_avg_Spine3 m_avg_Spine2 spine:0.58
m_avg_L_Foot m_avg_L_Ankle l_toe
m_avg_R_Foot m_avg_R_Ankle r_toe
m_avg_Neck m_avg_Spine3 neck
m_avg_L_Collar m_avg_Spine3 l_clavicle
m_avg_R_Collar m_avg_Spine3 r_clavicle
m_avg_Head m_avg_Neck head
m_avg_L_Shoulder m_avg_L_Collar l_shoulder
m_avg_R_Shoulder m_avg_R_Collar r_shoulder
m_avg_L_Elbow m_avg_L_Shoulder l_elbow
m_avg_R_Elbow m_avg_R_Shoulder r_elbow
m_avg_L_Wrist m_avg_L_Elbow l_wrist
m_avg_R_Wrist m_avg_R_Elbow r_wrist
m_avg_L_Hand m_avg_L_Wrist l_hand
m_avg_R_Hand m_avg_R_Wrist r_hand

convention smplh
kind joints
pelvis - pelvis
left_hip pelvis l_hip
right_hip pelvis r_hip
spine1 pelvis spine:0.22
left_knee left_hip l_knee
right_knee right_hip r_knee
spine2 spine1 spine:0.48
left_ankle left_knee l_ankle
right_ankle right_knee r_ankle
spine3 spine2 spine:0.58
left_foot left_ankle l_toe
right_foot right_ankle r_toe
neck spine3 neck
left_collar spine3 l_clavicle
right_collar spine3 r_clavicle
head neck head
left_shoulder left_collar l_shoulder
right_shoulder right_collar r_shoulder
left_elbow left_shoulder l_elbow
right_elbow right_shoulder r_elbow
left_wrist left_elbow l_wrist
right_wrist right_elbow r_wrist
left_index1 left_wrist l_finger:2:1
left_index2 left_index1 l_finger:2:2
left_index3 left_index2 l_finger:2:3
left_middle1 left_wrist l_finger:3:1
left_middle2 left_middle1 l_finger:3:2
left_middle3 left_middle2 l_finger:3:3
left_pinky1 left_wrist l_finger:5:1
left_pinky2 left_pinky1 l_finger:5:2
left_pinky3 left_pinky2 l_finger:5:3
left_ring1 left_wrist l_finger:4:1
left_ring2 left_ring1 l_finger:4:2
left_ring3 left_ring2 l_finger:4:3
left_thumb1 left_wrist l_finger:1:1
left_thumb2 left_thumb1 l_finger:1:2
left_thumb3 left_thumb2 l_finger:1:3
right_index1 right_wrist r_finger:2:1
right_index2 right_index1 r_finger:2:2
right_index3 right_index2 r_finger:2:3
right_middle1 right_wrist r_finger:3:1
right_middle2 right_middle1 r_finger:3:2
right_middle3 right_middle2 r_finger:3:3
right_pinky1 right_wrist r_finger:5:1
right_pinky2 right_pinky1 r_finger:5:2
right_pinky3 right_pinky2 r_finger:5:3
right_ring1 right_wrist r_finger:4:1
right_ring2 right_ring1 r_finger:4:2
right_ring3 right_ring2 r_finger:4:3
right_thumb1 right_wrist r_finger:1:1
right_thumb2 right_thumb1 r_finger:1:2
right_thumb3 right_thumb2 r_finger:1:3

convention smplx
kind joints
pelvis - pelvis
left_hip pelvis l_hip
right_hip pelvis r_hip
spine1 pelvis spine:0.22
left_knee left_hip l_knee
right_knee right_hip r_knee
spine2 spine1 spine:0.48
left_ankle left_knee l_ankle
right_ankle right_knee r_ankle
spine3 spine2 spine:0.58
left_foot left_ankle l_toe
right_foot right_ankle r_toe
neck spine3 neck
left_collar spine3 l_clavicle
right_collar spine3 r_clavicle
head neck head
left_shoulder left_collar l_shoulder
right_shoulder right_collar r_shoulder
left_elbow left_shoulder l_elbow
right_elbow right_shoulder r_elbow
left_wrist left_elbow l_wrist
right_wrist right_elbow r_wrist
jaw head jaw
left_eye_smplhf head l_eye
right_eye_smplhf head r_eye
left_index1 left_wrist l_finger:2:1
left_index2 left_index1 l_finger:2:2
left_index3 left_index2 l_finger:2:3
left_middle1 left_wrist l_finger:3:1
left_middle2 left_middle1 l_finger:3:2
left_middle3 left_middle2 l_finger:3:3
left_pinky1 left_wrist l_finger:5:1
left_pinky2 left_pinky1 l_finger:5:2
left_pinky3 left_pinky2 l_finger:5:3
left_ring1 left_wrist l_finger:4:1
left_ring2 left_ring1 l_finger:4:2
left_ring3 left_ring2 l_finger:4:3
left_thumb1 left_wrist l_finger:1:1
left_thumb2 left_thumb1 l_finger:1:2
left_thumb3 left_thumb2 l_finger:1:3
right_index1 right_wrist r_finger:2:1
right_index2 right_index1 r_finger:2:2
right_index3 right_index2 r_finger:2:3
right_middle1 right_wrist r_finger:3:1
right_middle2 right_middle1 r_finger:3:2
right_middle3 right_middle2 r_finger:3:3
right_pinky1 right_wrist r_finger:5:1
right_pinky2 right_pinky1 r_finger:5:2
right_pinky3 right_pinky2 r_finger:5:3
right_ring1 right_wrist r_finger:4:1
right_ring2 right_ring1 r_finger:4:2
right_ring3 right_ring2 r_finger:4:3
right_thumb1 right_wrist r_finger:1:1
right_thumb2 right_thumb1 r_finger:1:2
right_thumb3 right_thumb2 r_finger:1:3

convention smpl_lower_case_22
# Bodies of AMASS and HumanML3D as a hierarchy.
kind joints
pelvis - pelvis
left_hip pelvis l_hip
right_hip pelvis r_hip
spine1 pelvis spine:0.22
left_knee left_hip l_knee
right_knee right_hip r_knee
spine2 spine1 spine:0.48
left_ankle left_knee l_ankle
right_ankle right_knee r_ankle
spine3 spine2 spine:0.58
left_foot left_ankle l_toe
right_foot right_ankle r_toe
neck spine3 neck
left_collar spine3 l_clavicle
right_collar spine3 r_clavicle
head neck head
left_shoulder left_collar l_shoulder
right_shoulder right_collar r_shoulder
left_elbow left_shoulder l_elbow
right_elbow right_shoulder r_elbow
left_wrist left_elbow l_wrist
right_wrist right_elbow r_wrist

convention kit_mmm
# As in KIT-ML.
kind joints
root - pelvis
BP root spine:0.13
BT BP spine:0.32
BLN BT neck
BUN BLN head
LS BT l_shoulder
LE LS l_elbow
LW LE l_wrist
RS BT r_shoulder
RE RS r_elbow
RW RE r_wrist
LH root l_hip
LK LH l_knee
LA LK l_ankle
LMrot LA between:l_ankle:l_toe:0.4
LF LMrot l_toe
RH root r_hip
RK RH r_knee
RA RK r_ankle
RMrot RA between:r_ankle:r_toe:0.4
RF RMrot r_toe

convention kit_mmm_axis_joints
# One joint for each axis of rotation, at the same place.
kind joints
root - pelvis
BPx_joint root spine:0.13
BPy_joint BPx_joint spine:0.13
BPz_joint BPy_joint spine:0.13
BTx_joint BPz_joint spine:0.32
BTy_joint BTx_joint spine:0.32
BTz_joint BTy_joint spine:0.32
BLNx_joint BTz_joint neck
BLNy_joint BLNx_joint neck
BLNz_joint BLNy_joint neck
BUNx_joint BLNz_joint head
BUNy_joint BUNx_joint head
BUNz_joint BUNy_joint head
LSx_joint BTz_joint l_shoulder
LSy_joint LSx_joint l_shoulder
LSz_joint LSy_joint l_shoulder
LEx_joint LSz_joint l_elbow
LEz_joint LEx_joint l_elbow
LWx_joint LEz_joint l_wrist
LWy_joint LWx_joint l_wrist
RSx_joint BTz_joint r_shoulder
RSy_joint RSx_joint r_shoulder
RSz_joint RSy_joint r_shoulder
REx_joint RSz_joint r_elbow
REz_joint REx_joint r_elbow
RWx_joint REz_joint r_wrist
RWy_joint RWx_joint r_wrist
LHx_joint root l_hip
LHy_joint LHx_joint l_hip
LHz_joint LHy_joint l_hip
LKx_joint LHz_joint l_knee
LAx_joint LKx_joint l_ankle
LAy_joint LAx_joint l_ankle
LAz_joint LAy_joint l_ankle
LMrot_joint LAz_joint between:l_ankle:l_toe:0.4
LFx_joint LMrot_joint l_toe
RHx_joint root r_hip
RHy_joint RHx_joint r_hip
RHz_joint RHy_joint r_hip
RKx_joint RHz_joint r_knee
RAx_joint RKx_joint r_ankle
RAy_joint RAx_joint r_ankle
RAz_joint RAy_joint r_ankle
RMrot_joint RAz_joint between:r_ankle:r_toe:0.4
RFx_joint RMrot_joint r_toe

convention kit_mmm_segment_joints
kind joints
Root_joint - pelvis
BPSegment_joint Root_joint spine:0.13
BTSegment_joint BPSegment_joint spine:0.32
BLNsegment_joint BTSegment_joint neck
BUNsegment_joint BLNsegment_joint head
LSCsegment_joint BTSegment_joint l_clavicle
LSsegment_joint LSCsegment_joint l_shoulder
LEsegment_joint LSsegment_joint l_elbow
LWsegment_joint LEsegment_joint l_wrist
RSCsegment_joint BTSegment_joint r_clavicle
RSsegment_joint RSCsegment_joint r_shoulder
REsegment_joint RSsegment_joint r_elbow
RWsegment_joint REsegment_joint r_wrist
LHsegment_joint Root_joint l_hip
LKsegment_joint LHsegment_joint l_knee
LAsegment_joint LKsegment_joint l_ankle
LFsegment_joint LAsegment_joint l_toe
RHsegment_joint Root_joint r_hip
RKsegment_joint RHsegment_joint r_knee
RAsegment_joint RKsegment_joint r_ankle
RFsegment_joint RAsegment_joint r_toe

convention soma_77
kind joints
Hips - pelvis
Spine1 Hips spine:0.17
Spine2 Spine1 spine:0.4
Chest Spine2 spine:0.62
Neck1 Chest neck
Neck2 Neck1 between:neck:head:0.5
Head Neck2 head
HeadEnd Head head_top
Jaw Head jaw
LeftEye Head l_eye
RightEye Head r_eye
LeftShoulder Chest l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb1 LeftHand l_finger:1:1
LeftHandThumb2 LeftHandThumb1 l_finger:1:2
LeftHandThumb3 LeftHandThumb2 l_finger:1:3
LeftHandThumbEnd LeftHandThumb3 l_finger:1:4
LeftHandIndex1 LeftHand between:l_wrist:l_hand:0.3
LeftHandIndex2 LeftHandIndex1 l_finger:2:1
LeftHandIndex3 LeftHandIndex2 l_finger:2:2
LeftHandIndex4 LeftHandIndex3 l_finger:2:3
LeftHandIndexEnd LeftHandIndex4 l_finger:2:4
LeftHandMiddle1 LeftHand between:l_wrist:l_hand:0.3
LeftHandMiddle2 LeftHandMiddle1 l_finger:3:1
LeftHandMiddle3 LeftHandMiddle2 l_finger:3:2
LeftHandMiddle4 LeftHandMiddle3 l_finger:3:3
LeftHandMiddleEnd LeftHandMiddle4 l_finger:3:4
LeftHandRing1 LeftHand between:l_wrist:l_hand:0.3
LeftHandRing2 LeftHandRing1 l_finger:4:1
LeftHandRing3 LeftHandRing2 l_finger:4:2
LeftHandRing4 LeftHandRing3 l_finger:4:3
LeftHandRingEnd LeftHandRing4 l_finger:4:4
LeftHandPinky1 LeftHand between:l_wrist:l_hand:0.3
LeftHandPinky2 LeftHandPinky1 l_finger:5:1
LeftHandPinky3 LeftHandPinky2 l_finger:5:2
LeftHandPinky4 LeftHandPinky3 l_finger:5:3
LeftHandPinkyEnd LeftHandPinky4 l_finger:5:4
RightShoulder Chest r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb1 RightHand r_finger:1:1
RightHandThumb2 RightHandThumb1 r_finger:1:2
RightHandThumb3 RightHandThumb2 r_finger:1:3
RightHandThumbEnd RightHandThumb3 r_finger:1:4
RightHandIndex1 RightHand between:r_wrist:r_hand:0.3
RightHandIndex2 RightHandIndex1 r_finger:2:1
RightHandIndex3 RightHandIndex2 r_finger:2:2
RightHandIndex4 RightHandIndex3 r_finger:2:3
RightHandIndexEnd RightHandIndex4 r_finger:2:4
RightHandMiddle1 RightHand between:r_wrist:r_hand:0.3
RightHandMiddle2 RightHandMiddle1 r_finger:3:1
RightHandMiddle3 RightHandMiddle2 r_finger:3:2
RightHandMiddle4 RightHandMiddle3 r_finger:3:3
RightHandMiddleEnd RightHandMiddle4 r_finger:3:4
RightHandRing1 RightHand between:r_wrist:r_hand:0.3
RightHandRing2 RightHandRing1 r_finger:4:1
RightHandRing3 RightHandRing2 r_finger:4:2
RightHandRing4 RightHandRing3 r_finger:4:3
RightHandRingEnd RightHandRing4 r_finger:4:4
RightHandPinky1 RightHand between:r_wrist:r_hand:0.3
RightHandPinky2 RightHandPinky1 r_finger:5:1
RightHandPinky3 RightHandPinky2 r_finger:5:2
RightHandPinky4 RightHandPinky3 r_finger:5:3
RightHandPinkyEnd RightHandPinky4 r_finger:5:4
LeftLeg Hips l_hip
LeftShin LeftLeg l_knee
LeftFoot LeftShin l_ankle
LeftToeBase LeftFoot l_toe
LeftToeEnd LeftToeBase l_toe_tip
RightLeg Hips r_hip
RightShin RightLeg r_knee
RightFoot RightShin r_ankle
RightToeBase RightFoot r_toe
RightToeEnd RightToeBase r_toe_tip

convention soma_with_root_body_only
# As in BONES-SEED, without fingers.
kind joints
Root - floor
Hips Root pelvis
Spine1 Hips spine:0.17
Spine2 Spine1 spine:0.4
Chest Spine2 spine:0.62
Neck1 Chest neck
Neck2 Neck1 between:neck:head:0.5
Head Neck2 head
HeadEnd Head head_top
Jaw Head jaw
LeftEye Head l_eye
RightEye Head r_eye
LeftShoulder Chest l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
RightShoulder Chest r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
LeftLeg Hips l_hip
LeftShin LeftLeg l_knee
LeftFoot LeftShin l_ankle
LeftToeBase LeftFoot l_toe
LeftToeEnd LeftToeBase l_toe_tip
RightLeg Hips r_hip
RightShin RightLeg r_knee
RightFoot RightShin r_ankle
RightToeBase RightFoot r_toe
RightToeEnd RightToeBase r_toe_tip

convention arkit_body
kind joints
root - pelvis
hips_joint root pelvis
left_upLeg_joint hips_joint l_hip
left_leg_joint left_upLeg_joint l_knee
left_foot_joint left_leg_joint l_ankle
left_toes_joint left_foot_joint l_toe
left_toesEnd_joint left_toes_joint l_toe_tip
right_upLeg_joint hips_joint r_hip
right_leg_joint right_upLeg_joint r_knee
right_foot_joint right_leg_joint r_ankle
right_toes_joint right_foot_joint r_toe
right_toesEnd_joint right_toes_joint r_toe_tip
spine_1_joint hips_joint spine:0.1
spine_2_joint spine_1_joint spine:0.23
spine_3_joint spine_2_joint spine:0.37
spine_4_joint spine_3_joint spine:0.5
spine_5_joint spine_4_joint spine:0.63
spine_6_joint spine_5_joint spine:0.76
spine_7_joint spine_6_joint spine:0.88
left_shoulder_1_joint spine_7_joint l_clavicle
left_arm_joint left_shoulder_1_joint l_shoulder
left_forearm_joint left_arm_joint l_elbow
left_hand_joint left_forearm_joint l_wrist
left_handIndexStart_joint left_hand_joint between:l_wrist:l_hand:0.3
left_handIndex_1_joint left_handIndexStart_joint l_finger:2:1
left_handIndex_2_joint left_handIndex_1_joint l_finger:2:2
left_handIndex_3_joint left_handIndex_2_joint l_finger:2:3
left_handIndexEnd_joint left_handIndex_3_joint l_finger:2:4
left_handMidStart_joint left_hand_joint between:l_wrist:l_hand:0.3
left_handMid_1_joint left_handMidStart_joint l_finger:3:1
left_handMid_2_joint left_handMid_1_joint l_finger:3:2
left_handMid_3_joint left_handMid_2_joint l_finger:3:3
left_handMidEnd_joint left_handMid_3_joint l_finger:3:4
left_handThumbStart_joint left_hand_joint l_finger:1:1
left_handThumb_1_joint left_handThumbStart_joint l_finger:1:2
left_handThumb_2_joint left_handThumb_1_joint l_finger:1:3
left_handThumbEnd_joint left_handThumb_2_joint l_finger:1:4
right_shoulder_1_joint spine_7_joint r_clavicle
right_arm_joint right_shoulder_1_joint r_shoulder
right_forearm_joint right_arm_joint r_elbow
right_hand_joint right_forearm_joint r_wrist
right_handIndexStart_joint right_hand_joint between:r_wrist:r_hand:0.3
right_handIndex_1_joint right_handIndexStart_joint r_finger:2:1
right_handIndex_2_joint right_handIndex_1_joint r_finger:2:2
right_handIndex_3_joint right_handIndex_2_joint r_finger:2:3
right_handIndexEnd_joint right_handIndex_3_joint r_finger:2:4
right_handMidStart_joint right_hand_joint between:r_wrist:r_hand:0.3
right_handMid_1_joint right_handMidStart_joint r_finger:3:1
right_handMid_2_joint right_handMid_1_joint r_finger:3:2
right_handMid_3_joint right_handMid_2_joint r_finger:3:3
right_handMidEnd_joint right_handMid_3_joint r_finger:3:4
right_handThumbStart_joint right_hand_joint r_finger:1:1
right_handThumb_1_joint right_handThumbStart_joint r_finger:1:2
right_handThumb_2_joint right_handThumb_1_joint r_finger:1:3
right_handThumbEnd_joint right_handThumb_2_joint r_finger:1:4
neck_1_joint spine_7_joint neck
neck_2_joint neck_1_joint between:neck:head:0.25
neck_3_joint neck_2_joint between:neck:head:0.5
neck_4_joint neck_3_joint between:neck:head:0.75
head_joint neck_4_joint head
jaw_joint head_joint jaw
left_eye_joint head_joint l_eye
nose_joint head_joint nose
right_eye_joint head_joint r_eye
)";
  return kTable;
}

}  // namespace motiondb::tests
