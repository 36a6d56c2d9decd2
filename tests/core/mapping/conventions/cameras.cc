// Points (and one hierarchy) of depth cameras and pose estimators; names and hierarchies as
// published. Test data; format in skeleton_conventions.h.
// Conventions: kinect_v1_20, kinect_v1_underscores, kinect_v2_25, ntu_rgbd_described,
// azure_kinect_32, nuitrack, openni_15, openpose_body_25, openpose_coco_18, coco_17, coco_17_short,
// coco_17_camel_case, halpe_26, mediapipe_pose_33, mediapipe_pose_33_upper_case, humanml3d_22,
// amass_24, smpl_24_capitals, human36m_17, human36m_17_pelvis_spelling, human36m_17_mmpose,
// mpii_16, mpi_inf_3dhp_28, kit_ml_21.
#include <string_view>

#include "tests/core/mapping/conventions/skeleton_conventions.h"

namespace motiondb::tests {

std::string_view CameraConventions() {
  static constexpr std::string_view kTable = R"(
convention kinect_v1_20
kind points
HipCenter - pelvis
Spine - spine:0.3
ShoulderCenter - neck
Head - between:head:head_top:0.5
ShoulderLeft - l_shoulder
ElbowLeft - l_elbow
WristLeft - l_wrist
HandLeft - l_hand
ShoulderRight - r_shoulder
ElbowRight - r_elbow
WristRight - r_wrist
HandRight - r_hand
HipLeft - l_hip
KneeLeft - l_knee
AnkleLeft - l_ankle
FootLeft - l_toe
HipRight - r_hip
KneeRight - r_knee
AnkleRight - r_ankle
FootRight - r_toe

convention kinect_v1_underscores
kind points
HIP_CENTER - pelvis
SPINE - spine:0.3
SHOULDER_CENTER - neck
HEAD - between:head:head_top:0.5
SHOULDER_LEFT - l_shoulder
ELBOW_LEFT - l_elbow
WRIST_LEFT - l_wrist
HAND_LEFT - l_hand
SHOULDER_RIGHT - r_shoulder
ELBOW_RIGHT - r_elbow
WRIST_RIGHT - r_wrist
HAND_RIGHT - r_hand
HIP_LEFT - l_hip
KNEE_LEFT - l_knee
ANKLE_LEFT - l_ankle
FOOT_LEFT - l_toe
HIP_RIGHT - r_hip
KNEE_RIGHT - r_knee
ANKLE_RIGHT - r_ankle
FOOT_RIGHT - r_toe

convention kinect_v2_25
kind points
SpineBase - pelvis
SpineMid - spine:0.5
Neck - between:neck:head:0.5
Head - between:head:head_top:0.5
ShoulderLeft - l_shoulder
ElbowLeft - l_elbow
WristLeft - l_wrist
HandLeft - l_hand
ShoulderRight - r_shoulder
ElbowRight - r_elbow
WristRight - r_wrist
HandRight - r_hand
HipLeft - l_hip
KneeLeft - l_knee
AnkleLeft - l_ankle
FootLeft - l_toe
HipRight - r_hip
KneeRight - r_knee
AnkleRight - r_ankle
FootRight - r_toe
SpineShoulder - neck
HandTipLeft - l_finger:3:4
ThumbLeft - l_finger:1:4
HandTipRight - r_finger:3:4
ThumbRight - r_finger:1:4

convention ntu_rgbd_described
# As in the description of NTU RGB+D; 21 is "spine", between the shoulders.
kind points
base~of~the~spine - pelvis
middle~of~the~spine - spine:0.5
neck - between:neck:head:0.5
head - between:head:head_top:0.5
left~shoulder - l_shoulder
left~elbow - l_elbow
left~wrist - l_wrist
left~hand - l_hand
right~shoulder - r_shoulder
right~elbow - r_elbow
right~wrist - r_wrist
right~hand - r_hand
left~hip - l_hip
left~knee - l_knee
left~ankle - l_ankle
left~foot - l_toe
right~hip - r_hip
right~knee - r_knee
right~ankle - r_ankle
right~foot - r_toe
spine - neck
tip~of~the~left~hand - l_finger:3:4
left~thumb - l_finger:1:4
tip~of~the~right~hand - r_finger:3:4
right~thumb - r_finger:1:4

convention azure_kinect_32
kind joints
PELVIS - pelvis
SPINE_NAVEL PELVIS spine:0.35
SPINE_CHEST SPINE_NAVEL spine:0.7
NECK SPINE_CHEST neck
CLAVICLE_LEFT SPINE_CHEST l_clavicle
SHOULDER_LEFT CLAVICLE_LEFT l_shoulder
ELBOW_LEFT SHOULDER_LEFT l_elbow
WRIST_LEFT ELBOW_LEFT l_wrist
HAND_LEFT WRIST_LEFT l_hand
HANDTIP_LEFT HAND_LEFT l_finger:3:4
THUMB_LEFT WRIST_LEFT l_finger:1:4
CLAVICLE_RIGHT SPINE_CHEST r_clavicle
SHOULDER_RIGHT CLAVICLE_RIGHT r_shoulder
ELBOW_RIGHT SHOULDER_RIGHT r_elbow
WRIST_RIGHT ELBOW_RIGHT r_wrist
HAND_RIGHT WRIST_RIGHT r_hand
HANDTIP_RIGHT HAND_RIGHT r_finger:3:4
THUMB_RIGHT WRIST_RIGHT r_finger:1:4
HIP_LEFT PELVIS l_hip
KNEE_LEFT HIP_LEFT l_knee
ANKLE_LEFT KNEE_LEFT l_ankle
FOOT_LEFT ANKLE_LEFT l_toe
HIP_RIGHT PELVIS r_hip
KNEE_RIGHT HIP_RIGHT r_knee
ANKLE_RIGHT KNEE_RIGHT r_ankle
FOOT_RIGHT ANKLE_RIGHT r_toe
HEAD NECK head
NOSE HEAD nose
EYE_LEFT HEAD l_eye
EAR_LEFT HEAD l_ear
EYE_RIGHT HEAD r_eye
EAR_RIGHT HEAD r_ear

convention nuitrack
kind points
HEAD - between:head:head_top:0.5
NECK - neck
TORSO - spine:0.5
WAIST - pelvis
LEFT_COLLAR - neck
LEFT_SHOULDER - l_shoulder
LEFT_ELBOW - l_elbow
LEFT_WRIST - l_wrist
LEFT_HAND - l_hand
RIGHT_COLLAR - neck
RIGHT_SHOULDER - r_shoulder
RIGHT_ELBOW - r_elbow
RIGHT_WRIST - r_wrist
RIGHT_HAND - r_hand
LEFT_HIP - l_hip
LEFT_KNEE - l_knee
LEFT_ANKLE - l_ankle
RIGHT_HIP - r_hip
RIGHT_KNEE - r_knee
RIGHT_ANKLE - r_ankle

convention openni_15
kind points
Head - between:head:head_top:0.5
Neck - neck
LeftShoulder - l_shoulder
LeftElbow - l_elbow
LeftHand - l_wrist
RightShoulder - r_shoulder
RightElbow - r_elbow
RightHand - r_wrist
Torso - spine:0.5
LeftHip - l_hip
LeftKnee - l_knee
LeftFoot - l_ankle
RightHip - r_hip
RightKnee - r_knee
RightFoot - r_ankle

convention openpose_body_25
kind points
Nose - nose
Neck - neck
RShoulder - r_shoulder
RElbow - r_elbow
RWrist - r_wrist
LShoulder - l_shoulder
LElbow - l_elbow
LWrist - l_wrist
MidHip - pelvis
RHip - r_hip
RKnee - r_knee
RAnkle - r_ankle
LHip - l_hip
LKnee - l_knee
LAnkle - l_ankle
REye - r_eye
LEye - l_eye
REar - r_ear
LEar - l_ear
LBigToe - l_toe_tip
LSmallToe - l_toe_small
LHeel - l_heel
RBigToe - r_toe_tip
RSmallToe - r_toe_small
RHeel - r_heel

convention openpose_coco_18
kind points
Nose - nose
Neck - neck
RShoulder - r_shoulder
RElbow - r_elbow
RWrist - r_wrist
LShoulder - l_shoulder
LElbow - l_elbow
LWrist - l_wrist
RHip - r_hip
RKnee - r_knee
RAnkle - r_ankle
LHip - l_hip
LKnee - l_knee
LAnkle - l_ankle
REye - r_eye
LEye - l_eye
REar - r_ear
LEar - l_ear

convention coco_17
kind points
nose - nose
left_eye - l_eye
right_eye - r_eye
left_ear - l_ear
right_ear - r_ear
left_shoulder - l_shoulder
right_shoulder - r_shoulder
left_elbow - l_elbow
right_elbow - r_elbow
left_wrist - l_wrist
right_wrist - r_wrist
left_hip - l_hip
right_hip - r_hip
left_knee - l_knee
right_knee - r_knee
left_ankle - l_ankle
right_ankle - r_ankle

convention coco_17_short
kind points
Nose - nose
LEye - l_eye
REye - r_eye
LEar - l_ear
REar - r_ear
LShoulder - l_shoulder
RShoulder - r_shoulder
LElbow - l_elbow
RElbow - r_elbow
LWrist - l_wrist
RWrist - r_wrist
LHip - l_hip
RHip - r_hip
LKnee - l_knee
RKnee - r_knee
LAnkle - l_ankle
RAnkle - r_ankle

convention coco_17_camel_case
# As in PoseNet.
kind points
nose - nose
leftEye - l_eye
rightEye - r_eye
leftEar - l_ear
rightEar - r_ear
leftShoulder - l_shoulder
rightShoulder - r_shoulder
leftElbow - l_elbow
rightElbow - r_elbow
leftWrist - l_wrist
rightWrist - r_wrist
leftHip - l_hip
rightHip - r_hip
leftKnee - l_knee
rightKnee - r_knee
leftAnkle - l_ankle
rightAnkle - r_ankle

convention halpe_26
kind points
Nose - nose
LEye - l_eye
REye - r_eye
LEar - l_ear
REar - r_ear
LShoulder - l_shoulder
RShoulder - r_shoulder
LElbow - l_elbow
RElbow - r_elbow
LWrist - l_wrist
RWrist - r_wrist
LHip - l_hip
RHip - r_hip
LKnee - l_knee
RKnee - r_knee
LAnkle - l_ankle
RAnkle - r_ankle
Head - head_top
Neck - neck
Hip - pelvis
LBigToe - l_toe_tip
RBigToe - r_toe_tip
LSmallToe - l_toe_small
RSmallToe - r_toe_small
LHeel - l_heel
RHeel - r_heel

convention mediapipe_pose_33
kind points
nose - nose
left_eye_inner - l_eye
left_eye - l_eye
left_eye_outer - l_eye
right_eye_inner - r_eye
right_eye - r_eye
right_eye_outer - r_eye
left_ear - l_ear
right_ear - r_ear
mouth_left - jaw
mouth_right - jaw
left_shoulder - l_shoulder
right_shoulder - r_shoulder
left_elbow - l_elbow
right_elbow - r_elbow
left_wrist - l_wrist
right_wrist - r_wrist
left_pinky - l_finger:5:1
right_pinky - r_finger:5:1
left_index - l_finger:2:1
right_index - r_finger:2:1
left_thumb - l_finger:1:2
right_thumb - r_finger:1:2
left_hip - l_hip
right_hip - r_hip
left_knee - l_knee
right_knee - r_knee
left_ankle - l_ankle
right_ankle - r_ankle
left_heel - l_heel
right_heel - r_heel
left_foot_index - l_toe_tip
right_foot_index - r_toe_tip

convention mediapipe_pose_33_upper_case
kind points
NOSE - nose
LEFT_EYE_INNER - l_eye
LEFT_EYE - l_eye
LEFT_EYE_OUTER - l_eye
RIGHT_EYE_INNER - r_eye
RIGHT_EYE - r_eye
RIGHT_EYE_OUTER - r_eye
LEFT_EAR - l_ear
RIGHT_EAR - r_ear
MOUTH_LEFT - jaw
MOUTH_RIGHT - jaw
LEFT_SHOULDER - l_shoulder
RIGHT_SHOULDER - r_shoulder
LEFT_ELBOW - l_elbow
RIGHT_ELBOW - r_elbow
LEFT_WRIST - l_wrist
RIGHT_WRIST - r_wrist
LEFT_PINKY - l_finger:5:1
RIGHT_PINKY - r_finger:5:1
LEFT_INDEX - l_finger:2:1
RIGHT_INDEX - r_finger:2:1
LEFT_THUMB - l_finger:1:2
RIGHT_THUMB - r_finger:1:2
LEFT_HIP - l_hip
RIGHT_HIP - r_hip
LEFT_KNEE - l_knee
RIGHT_KNEE - r_knee
LEFT_ANKLE - l_ankle
RIGHT_ANKLE - r_ankle
LEFT_HEEL - l_heel
RIGHT_HEEL - r_heel
LEFT_FOOT_INDEX - l_toe_tip
RIGHT_FOOT_INDEX - r_toe_tip

convention humanml3d_22
kind points
pelvis - pelvis
left_hip - l_hip
right_hip - r_hip
spine1 - spine:0.22
left_knee - l_knee
right_knee - r_knee
spine2 - spine:0.48
left_ankle - l_ankle
right_ankle - r_ankle
spine3 - spine:0.58
left_foot - l_toe
right_foot - r_toe
neck - neck
left_collar - l_clavicle
right_collar - r_clavicle
head - head
left_shoulder - l_shoulder
right_shoulder - r_shoulder
left_elbow - l_elbow
right_elbow - r_elbow
left_wrist - l_wrist
right_wrist - r_wrist

convention amass_24
kind points
pelvis - pelvis
left_hip - l_hip
right_hip - r_hip
spine1 - spine:0.22
left_knee - l_knee
right_knee - r_knee
spine2 - spine:0.48
left_ankle - l_ankle
right_ankle - r_ankle
spine3 - spine:0.58
left_foot - l_toe
right_foot - r_toe
neck - neck
left_collar - l_clavicle
right_collar - r_clavicle
head - head
left_shoulder - l_shoulder
right_shoulder - r_shoulder
left_elbow - l_elbow
right_elbow - r_elbow
left_wrist - l_wrist
right_wrist - r_wrist
left_hand - l_hand
right_hand - r_hand

convention smpl_24_capitals
kind points
Pelvis - pelvis
L_Hip - l_hip
R_Hip - r_hip
Spine1 - spine:0.22
L_Knee - l_knee
R_Knee - r_knee
Spine2 - spine:0.48
L_Ankle - l_ankle
R_Ankle - r_ankle
Spine3 - spine:0.58
L_Foot - l_toe
R_Foot - r_toe
Neck - neck
L_Collar - l_clavicle
R_Collar - r_clavicle
Head - head
L_Shoulder - l_shoulder
R_Shoulder - r_shoulder
L_Elbow - l_elbow
R_Elbow - r_elbow
L_Wrist - l_wrist
R_Wrist - r_wrist
L_Hand - l_hand
R_Hand - r_hand

convention human36m_17
# Foot is the ankle.
kind points
Hip - pelvis
RHip - r_hip
RKnee - r_knee
RFoot - r_ankle
LHip - l_hip
LKnee - l_knee
LFoot - l_ankle
Spine - spine:0.5
Thorax - neck
Neck/Nose - head
Head - head_top
LShoulder - l_shoulder
LElbow - l_elbow
LWrist - l_wrist
RShoulder - r_shoulder
RElbow - r_elbow
RWrist - r_wrist

convention human36m_17_pelvis_spelling
kind points
Pelvis - pelvis
R_Hip - r_hip
R_Knee - r_knee
R_Ankle - r_ankle
L_Hip - l_hip
L_Knee - l_knee
L_Ankle - l_ankle
Torso - spine:0.5
Neck - neck
Nose - nose
Head - head_top
L_Shoulder - l_shoulder
L_Elbow - l_elbow
L_Wrist - l_wrist
R_Shoulder - r_shoulder
R_Elbow - r_elbow
R_Wrist - r_wrist

convention human36m_17_mmpose
# Foot is the ankle; neck_base is above thorax.
kind points
root - pelvis
right_hip - r_hip
right_knee - r_knee
right_foot - r_ankle
left_hip - l_hip
left_knee - l_knee
left_foot - l_ankle
spine - spine:0.5
thorax - neck
neck_base - head
head - head_top
left_shoulder - l_shoulder
left_elbow - l_elbow
left_wrist - l_wrist
right_shoulder - r_shoulder
right_elbow - r_elbow
right_wrist - r_wrist

convention mpii_16
kind points
right_ankle - r_ankle
right_knee - r_knee
right_hip - r_hip
left_hip - l_hip
left_knee - l_knee
left_ankle - l_ankle
pelvis - pelvis
thorax - neck
upper_neck - head
head_top - head_top
right_wrist - r_wrist
right_elbow - r_elbow
right_shoulder - r_shoulder
left_shoulder - l_shoulder
left_elbow - l_elbow
left_wrist - l_wrist

convention mpi_inf_3dhp_28
kind points
spine3 - spine:0.62
spine4 - spine:0.82
spine2 - spine:0.43
spine - spine:0.15
pelvis - pelvis
neck - neck
head - head
head_top - head_top
left_clavicle - l_clavicle
left_shoulder - l_shoulder
left_elbow - l_elbow
left_wrist - l_wrist
left_hand - l_hand
right_clavicle - r_clavicle
right_shoulder - r_shoulder
right_elbow - r_elbow
right_wrist - r_wrist
right_hand - r_hand
left_hip - l_hip
left_knee - l_knee
left_ankle - l_ankle
left_foot - l_toe
left_toe - l_toe_tip
right_hip - r_hip
right_knee - r_knee
right_ankle - r_ankle
right_foot - r_toe
right_toe - r_toe_tip

convention kit_ml_21
kind points
root - pelvis
BP - spine:0.13
BT - spine:0.32
BLN - neck
BUN - head
LS - l_shoulder
LE - l_elbow
LW - l_wrist
RS - r_shoulder
RE - r_elbow
RW - r_wrist
LH - l_hip
LK - l_knee
LA - l_ankle
LMrot - between:l_ankle:l_toe:0.4
LF - l_toe
RH - r_hip
RK - r_knee
RA - r_ankle
RMrot - between:r_ankle:r_toe:0.4
RF - r_toe
)";
  return kTable;
}

}  // namespace motiondb::tests
