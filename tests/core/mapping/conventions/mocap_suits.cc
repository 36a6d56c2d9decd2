// Skeletons of motion capture suits and of optical and markerless systems; names and
// hierarchies as published. Test data; format in skeleton_conventions.h.
// Conventions: rokoko_newton, rokoko_newton_without_root, rokoko_bvh, xsens_mvn_segments,
// xsens_mvn_bvh, xsens_mvn_fbx, perception_neuron, perception_neuron_robot_prefix,
// perception_neuron_axis_studio, optitrack_motive, optitrack_motive_csv, optitrack_motive_fbx,
// optitrack_motive_motionbuilder_names, vicon_blade, vicon_shogun_solving,
// vicon_nexus_plug_in_gait_segments, captury_29, captury_fingers_root, qualisys_skeleton,
// ipi_mocap_studio, kinect_bvh_hips, kinect_bvh_poser_names, biovision_classic.
#include <string_view>

#include "tests/core/mapping/conventions/skeleton_conventions.h"

namespace motiondb::tests {

std::string_view MocapSuitConventions() {
  static constexpr std::string_view kTable = R"(
convention rokoko_newton
kind joints
Root - origin
Hips Root pelvis
Spine1 Hips spine:0.15
Spine2 Spine1 spine:0.33
Spine3 Spine2 spine:0.52
Spine4 Spine3 spine:0.72
Neck Spine4 neck
Head Neck head
RightShoulder Spine4 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightFinger1Metacarpal RightHand r_finger:1:1
RightFinger1Proximal RightFinger1Metacarpal r_finger:1:2
RightFinger1Distal RightFinger1Proximal r_finger:1:3
RightFinger2Metacarpal RightHand between:r_wrist:r_hand:0.3
RightFinger2Proximal RightFinger2Metacarpal r_finger:2:1
RightFinger2Medial RightFinger2Proximal r_finger:2:2
RightFinger2Distal RightFinger2Medial r_finger:2:3
RightFinger3Metacarpal RightHand between:r_wrist:r_hand:0.3
RightFinger3Proximal RightFinger3Metacarpal r_finger:3:1
RightFinger3Medial RightFinger3Proximal r_finger:3:2
RightFinger3Distal RightFinger3Medial r_finger:3:3
LeftShoulder Spine4 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftFinger1Metacarpal LeftHand l_finger:1:1
LeftFinger1Proximal LeftFinger1Metacarpal l_finger:1:2
LeftFinger1Distal LeftFinger1Proximal l_finger:1:3
LeftFinger2Metacarpal LeftHand between:l_wrist:l_hand:0.3
LeftFinger2Proximal LeftFinger2Metacarpal l_finger:2:1
LeftFinger2Medial LeftFinger2Proximal l_finger:2:2
LeftFinger2Distal LeftFinger2Medial l_finger:2:3
LeftFinger3Metacarpal LeftHand between:l_wrist:l_hand:0.3
LeftFinger3Proximal LeftFinger3Metacarpal l_finger:3:1
LeftFinger3Medial LeftFinger3Proximal l_finger:3:2
LeftFinger3Distal LeftFinger3Medial l_finger:3:3
RightThigh Hips r_hip
RightShin RightThigh r_knee
RightFoot RightShin r_ankle
RightToe RightFoot r_toe
LeftThigh Hips l_hip
LeftShin LeftThigh l_knee
LeftFoot LeftShin l_ankle
LeftToe LeftFoot l_toe

convention rokoko_newton_without_root
kind joints
Hips - pelvis
Spine1 Hips spine:0.15
Spine2 Spine1 spine:0.33
Spine3 Spine2 spine:0.52
Spine4 Spine3 spine:0.72
Neck Spine4 neck
Head Neck head
RightShoulder Spine4 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightFinger1Metacarpal RightHand r_finger:1:1
RightFinger1Proximal RightFinger1Metacarpal r_finger:1:2
RightFinger1Distal RightFinger1Proximal r_finger:1:3
RightFinger2Metacarpal RightHand between:r_wrist:r_hand:0.3
RightFinger2Proximal RightFinger2Metacarpal r_finger:2:1
RightFinger2Medial RightFinger2Proximal r_finger:2:2
RightFinger2Distal RightFinger2Medial r_finger:2:3
RightFinger3Metacarpal RightHand between:r_wrist:r_hand:0.3
RightFinger3Proximal RightFinger3Metacarpal r_finger:3:1
RightFinger3Medial RightFinger3Proximal r_finger:3:2
RightFinger3Distal RightFinger3Medial r_finger:3:3
LeftShoulder Spine4 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftFinger1Metacarpal LeftHand l_finger:1:1
LeftFinger1Proximal LeftFinger1Metacarpal l_finger:1:2
LeftFinger1Distal LeftFinger1Proximal l_finger:1:3
LeftFinger2Metacarpal LeftHand between:l_wrist:l_hand:0.3
LeftFinger2Proximal LeftFinger2Metacarpal l_finger:2:1
LeftFinger2Medial LeftFinger2Proximal l_finger:2:2
LeftFinger2Distal LeftFinger2Medial l_finger:2:3
LeftFinger3Metacarpal LeftHand between:l_wrist:l_hand:0.3
LeftFinger3Proximal LeftFinger3Metacarpal l_finger:3:1
LeftFinger3Medial LeftFinger3Proximal l_finger:3:2
LeftFinger3Distal LeftFinger3Medial l_finger:3:3
RightThigh Hips r_hip
RightShin RightThigh r_knee
RightFoot RightShin r_ankle
RightToe RightFoot r_toe
LeftThigh Hips l_hip
LeftShin LeftThigh l_knee
LeftFoot LeftShin l_ankle
LeftToe LeftFoot l_toe

convention rokoko_bvh
kind joints
Hips - pelvis
Spine Hips spine:0.26
Spine1 Spine spine:0.51
Spine2 Spine1 spine:0.75
LeftShoulder Spine2 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftInHandIndex LeftHand between:l_wrist:l_hand:0.3
LeftHandIndex1 LeftInHandIndex l_finger:2:1
LeftHandIndex2 LeftHandIndex1 l_finger:2:2
LeftHandIndex3 LeftHandIndex2 l_finger:2:3
LeftInHandMiddle LeftHand between:l_wrist:l_hand:0.3
LeftHandMiddle1 LeftInHandMiddle l_finger:3:1
LeftHandMiddle2 LeftHandMiddle1 l_finger:3:2
LeftHandMiddle3 LeftHandMiddle2 l_finger:3:3
LeftInHandPinky LeftHand between:l_wrist:l_hand:0.3
LeftHandPinky1 LeftInHandPinky l_finger:5:1
LeftHandPinky2 LeftHandPinky1 l_finger:5:2
LeftHandPinky3 LeftHandPinky2 l_finger:5:3
LeftInHandRing LeftHand between:l_wrist:l_hand:0.3
LeftHandRing1 LeftInHandRing l_finger:4:1
LeftHandRing2 LeftHandRing1 l_finger:4:2
LeftHandRing3 LeftHandRing2 l_finger:4:3
LeftHandThumb1 LeftHand l_finger:1:1
LeftHandThumb2 LeftHandThumb1 l_finger:1:2
LeftHandThumb3 LeftHandThumb2 l_finger:1:3
Neck Spine2 neck
Head Neck head
RightShoulder Spine2 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightInHandIndex RightHand between:r_wrist:r_hand:0.3
RightHandIndex1 RightInHandIndex r_finger:2:1
RightHandIndex2 RightHandIndex1 r_finger:2:2
RightHandIndex3 RightHandIndex2 r_finger:2:3
RightInHandMiddle RightHand between:r_wrist:r_hand:0.3
RightHandMiddle1 RightInHandMiddle r_finger:3:1
RightHandMiddle2 RightHandMiddle1 r_finger:3:2
RightHandMiddle3 RightHandMiddle2 r_finger:3:3
RightInHandPinky RightHand between:r_wrist:r_hand:0.3
RightHandPinky1 RightInHandPinky r_finger:5:1
RightHandPinky2 RightHandPinky1 r_finger:5:2
RightHandPinky3 RightHandPinky2 r_finger:5:3
RightInHandRing RightHand between:r_wrist:r_hand:0.3
RightHandRing1 RightInHandRing r_finger:4:1
RightHandRing2 RightHandRing1 r_finger:4:2
RightHandRing3 RightHandRing2 r_finger:4:3
RightHandThumb1 RightHand r_finger:1:1
RightHandThumb2 RightHandThumb1 r_finger:1:2
RightHandThumb3 RightHandThumb2 r_finger:1:3
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe

convention xsens_mvn_segments
kind joints
Pelvis - pelvis
L5 Pelvis spine:0.18
L3 L5 spine:0.37
T12 L3 spine:0.55
T8 T12 spine:0.72
Neck T8 neck
Head Neck head
RightShoulder T8 r_clavicle
RightUpperArm RightShoulder r_shoulder
RightForeArm RightUpperArm r_elbow
RightHand RightForeArm r_wrist
LeftShoulder T8 l_clavicle
LeftUpperArm LeftShoulder l_shoulder
LeftForeArm LeftUpperArm l_elbow
LeftHand LeftForeArm l_wrist
RightUpperLeg Pelvis r_hip
RightLowerLeg RightUpperLeg r_knee
RightFoot RightLowerLeg r_ankle
RightToe RightFoot r_toe
LeftUpperLeg Pelvis l_hip
LeftLowerLeg LeftUpperLeg l_knee
LeftFoot LeftLowerLeg l_ankle
LeftToe LeftFoot l_toe

convention xsens_mvn_bvh
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

convention xsens_mvn_fbx
kind joints
Reference - origin
Hips Reference pelvis
Spine Hips spine:0.18
Spine1 Spine spine:0.37
Spine2 Spine1 spine:0.55
Spine3 Spine2 spine:0.72
Neck Spine3 neck
Head Neck head
RightShoulder Spine3 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
LeftShoulder Spine3 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe

convention perception_neuron
kind joints
Hips - pelvis
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
Spine Hips spine:0.2
Spine1 Spine spine:0.37
Spine2 Spine1 spine:0.55
Spine3 Spine2 spine:0.72
Neck Spine3 neck
Head Neck head
RightShoulder Spine3 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb1 RightHand r_finger:1:1
RightHandThumb2 RightHandThumb1 r_finger:1:2
RightHandThumb3 RightHandThumb2 r_finger:1:3
RightInHandIndex RightHand between:r_wrist:r_hand:0.3
RightHandIndex1 RightInHandIndex r_finger:2:1
RightHandIndex2 RightHandIndex1 r_finger:2:2
RightHandIndex3 RightHandIndex2 r_finger:2:3
RightInHandMiddle RightHand between:r_wrist:r_hand:0.3
RightHandMiddle1 RightInHandMiddle r_finger:3:1
RightHandMiddle2 RightHandMiddle1 r_finger:3:2
RightHandMiddle3 RightHandMiddle2 r_finger:3:3
RightInHandRing RightHand between:r_wrist:r_hand:0.3
RightHandRing1 RightInHandRing r_finger:4:1
RightHandRing2 RightHandRing1 r_finger:4:2
RightHandRing3 RightHandRing2 r_finger:4:3
RightInHandPinky RightHand between:r_wrist:r_hand:0.3
RightHandPinky1 RightInHandPinky r_finger:5:1
RightHandPinky2 RightHandPinky1 r_finger:5:2
RightHandPinky3 RightHandPinky2 r_finger:5:3
LeftShoulder Spine3 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb1 LeftHand l_finger:1:1
LeftHandThumb2 LeftHandThumb1 l_finger:1:2
LeftHandThumb3 LeftHandThumb2 l_finger:1:3
LeftInHandIndex LeftHand between:l_wrist:l_hand:0.3
LeftHandIndex1 LeftInHandIndex l_finger:2:1
LeftHandIndex2 LeftHandIndex1 l_finger:2:2
LeftHandIndex3 LeftHandIndex2 l_finger:2:3
LeftInHandMiddle LeftHand between:l_wrist:l_hand:0.3
LeftHandMiddle1 LeftInHandMiddle l_finger:3:1
LeftHandMiddle2 LeftHandMiddle1 l_finger:3:2
LeftHandMiddle3 LeftHandMiddle2 l_finger:3:3
LeftInHandRing LeftHand between:l_wrist:l_hand:0.3
LeftHandRing1 LeftInHandRing l_finger:4:1
LeftHandRing2 LeftHandRing1 l_finger:4:2
LeftHandRing3 LeftHandRing2 l_finger:4:3
LeftInHandPinky LeftHand between:l_wrist:l_hand:0.3
LeftHandPinky1 LeftInHandPinky l_finger:5:1
LeftHandPinky2 LeftHandPinky1 l_finger:5:2
LeftHandPinky3 LeftHandPinky2 l_finger:5:3

convention perception_neuron_robot_prefix
kind joints
Robot_Hips - pelvis
Robot_RightUpLeg Robot_Hips r_hip
Robot_RightLeg Robot_RightUpLeg r_knee
Robot_RightFoot Robot_RightLeg r_ankle
Robot_LeftUpLeg Robot_Hips l_hip
Robot_LeftLeg Robot_LeftUpLeg l_knee
Robot_LeftFoot Robot_LeftLeg l_ankle
Robot_Spine Robot_Hips spine:0.2
Robot_Spine1 Robot_Spine spine:0.37
Robot_Spine2 Robot_Spine1 spine:0.55
Robot_Spine3 Robot_Spine2 spine:0.72
Robot_Neck Robot_Spine3 neck
Robot_Head Robot_Neck head
Robot_RightShoulder Robot_Spine3 r_clavicle
Robot_RightArm Robot_RightShoulder r_shoulder
Robot_RightForeArm Robot_RightArm r_elbow
Robot_RightHand Robot_RightForeArm r_wrist
Robot_RightHandThumb1 Robot_RightHand r_finger:1:1
Robot_RightHandThumb2 Robot_RightHandThumb1 r_finger:1:2
Robot_RightHandThumb3 Robot_RightHandThumb2 r_finger:1:3
Robot_RightInHandIndex Robot_RightHand between:r_wrist:r_hand:0.3
Robot_RightHandIndex1 Robot_RightInHandIndex r_finger:2:1
Robot_RightHandIndex2 Robot_RightHandIndex1 r_finger:2:2
Robot_RightHandIndex3 Robot_RightHandIndex2 r_finger:2:3
Robot_RightInHandMiddle Robot_RightHand between:r_wrist:r_hand:0.3
Robot_RightHandMiddle1 Robot_RightInHandMiddle r_finger:3:1
Robot_RightHandMiddle2 Robot_RightHandMiddle1 r_finger:3:2
Robot_RightHandMiddle3 Robot_RightHandMiddle2 r_finger:3:3
Robot_LeftShoulder Robot_Spine3 l_clavicle
Robot_LeftArm Robot_LeftShoulder l_shoulder
Robot_LeftForeArm Robot_LeftArm l_elbow
Robot_LeftHand Robot_LeftForeArm l_wrist
Robot_LeftHandThumb1 Robot_LeftHand l_finger:1:1
Robot_LeftHandThumb2 Robot_LeftHandThumb1 l_finger:1:2
Robot_LeftHandThumb3 Robot_LeftHandThumb2 l_finger:1:3
Robot_LeftInHandIndex Robot_LeftHand between:l_wrist:l_hand:0.3
Robot_LeftHandIndex1 Robot_LeftInHandIndex l_finger:2:1
Robot_LeftHandIndex2 Robot_LeftHandIndex1 l_finger:2:2
Robot_LeftHandIndex3 Robot_LeftHandIndex2 l_finger:2:3
Robot_LeftInHandMiddle Robot_LeftHand between:l_wrist:l_hand:0.3
Robot_LeftHandMiddle1 Robot_LeftInHandMiddle l_finger:3:1
Robot_LeftHandMiddle2 Robot_LeftHandMiddle1 l_finger:3:2
Robot_LeftHandMiddle3 Robot_LeftHandMiddle2 l_finger:3:3

convention perception_neuron_axis_studio
kind joints
Hips - pelvis
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
Spine Hips spine:0.2
Spine1 Spine spine:0.45
Spine2 Spine1 spine:0.72
Neck Spine2 neck
Neck1 Neck between:neck:head:0.5
Head Neck1 head
RightShoulder Spine2 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb1 RightHand r_finger:1:1
RightHandThumb2 RightHandThumb1 r_finger:1:2
RightHandThumb3 RightHandThumb2 r_finger:1:3
RightInHandIndex RightHand between:r_wrist:r_hand:0.3
RightHandIndex1 RightInHandIndex r_finger:2:1
RightHandIndex2 RightHandIndex1 r_finger:2:2
RightHandIndex3 RightHandIndex2 r_finger:2:3
RightInHandMiddle RightHand between:r_wrist:r_hand:0.3
RightHandMiddle1 RightInHandMiddle r_finger:3:1
RightHandMiddle2 RightHandMiddle1 r_finger:3:2
RightHandMiddle3 RightHandMiddle2 r_finger:3:3
LeftShoulder Spine2 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb1 LeftHand l_finger:1:1
LeftHandThumb2 LeftHandThumb1 l_finger:1:2
LeftHandThumb3 LeftHandThumb2 l_finger:1:3
LeftInHandIndex LeftHand between:l_wrist:l_hand:0.3
LeftHandIndex1 LeftInHandIndex l_finger:2:1
LeftHandIndex2 LeftHandIndex1 l_finger:2:2
LeftHandIndex3 LeftHandIndex2 l_finger:2:3
LeftInHandMiddle LeftHand between:l_wrist:l_hand:0.3
LeftHandMiddle1 LeftInHandMiddle l_finger:3:1
LeftHandMiddle2 LeftHandMiddle1 l_finger:3:2
LeftHandMiddle3 LeftHandMiddle2 l_finger:3:3

convention optitrack_motive
kind joints
Hip - pelvis
Ab Hip spine:0.15
Chest Ab spine:0.5
Neck Chest neck
Head Neck head
LShoulder Chest l_clavicle
LUArm LShoulder l_shoulder
LFArm LUArm l_elbow
LHand LFArm l_wrist
RShoulder Chest r_clavicle
RUArm RShoulder r_shoulder
RFArm RUArm r_elbow
RHand RFArm r_wrist
LThigh Hip l_hip
LShin LThigh l_knee
LFoot LShin l_ankle
LToe LFoot l_toe
RThigh Hip r_hip
RShin RThigh r_knee
RFoot RShin r_ankle
RToe RFoot r_toe

convention optitrack_motive_csv
# The root bears the name of the skeleton.
kind joints
Skeleton1 - pelvis
Skeleton1:Ab Skeleton1 spine:0.15
Skeleton1:Chest Skeleton1:Ab spine:0.5
Skeleton1:Neck Skeleton1:Chest neck
Skeleton1:Head Skeleton1:Neck head
Skeleton1:LShoulder Skeleton1:Chest l_clavicle
Skeleton1:LUArm Skeleton1:LShoulder l_shoulder
Skeleton1:LFArm Skeleton1:LUArm l_elbow
Skeleton1:LHand Skeleton1:LFArm l_wrist
Skeleton1:LThumb1 Skeleton1:LHand l_finger:1:1
Skeleton1:LThumb2 Skeleton1:LThumb1 l_finger:1:2
Skeleton1:LThumb3 Skeleton1:LThumb2 l_finger:1:3
Skeleton1:LIndex1 Skeleton1:LHand l_finger:2:1
Skeleton1:LIndex2 Skeleton1:LIndex1 l_finger:2:2
Skeleton1:LIndex3 Skeleton1:LIndex2 l_finger:2:3
Skeleton1:LMiddle1 Skeleton1:LHand l_finger:3:1
Skeleton1:LMiddle2 Skeleton1:LMiddle1 l_finger:3:2
Skeleton1:LMiddle3 Skeleton1:LMiddle2 l_finger:3:3
Skeleton1:RShoulder Skeleton1:Chest r_clavicle
Skeleton1:RUArm Skeleton1:RShoulder r_shoulder
Skeleton1:RFArm Skeleton1:RUArm r_elbow
Skeleton1:RHand Skeleton1:RFArm r_wrist
Skeleton1:RThumb1 Skeleton1:RHand r_finger:1:1
Skeleton1:RThumb2 Skeleton1:RThumb1 r_finger:1:2
Skeleton1:RThumb3 Skeleton1:RThumb2 r_finger:1:3
Skeleton1:RIndex1 Skeleton1:RHand r_finger:2:1
Skeleton1:RIndex2 Skeleton1:RIndex1 r_finger:2:2
Skeleton1:RIndex3 Skeleton1:RIndex2 r_finger:2:3
Skeleton1:RMiddle1 Skeleton1:RHand r_finger:3:1
Skeleton1:RMiddle2 Skeleton1:RMiddle1 r_finger:3:2
Skeleton1:RMiddle3 Skeleton1:RMiddle2 r_finger:3:3
Skeleton1:LThigh Skeleton1 l_hip
Skeleton1:LShin Skeleton1:LThigh l_knee
Skeleton1:LFoot Skeleton1:LShin l_ankle
Skeleton1:LToe Skeleton1:LFoot l_toe
Skeleton1:RThigh Skeleton1 r_hip
Skeleton1:RShin Skeleton1:RThigh r_knee
Skeleton1:RFoot Skeleton1:RShin r_ankle
Skeleton1:RToe Skeleton1:RFoot r_toe

convention optitrack_motive_fbx
kind joints
Skeleton_Hip - pelvis
Skeleton_Ab Skeleton_Hip spine:0.15
Skeleton_Chest Skeleton_Ab spine:0.5
Skeleton_Neck Skeleton_Chest neck
Skeleton_Head Skeleton_Neck head
Skeleton_LShoulder Skeleton_Chest l_clavicle
Skeleton_LUArm Skeleton_LShoulder l_shoulder
Skeleton_LFArm Skeleton_LUArm l_elbow
Skeleton_LHand Skeleton_LFArm l_wrist
Skeleton_LThumb1 Skeleton_LHand l_finger:1:1
Skeleton_LThumb2 Skeleton_LThumb1 l_finger:1:2
Skeleton_LThumb3 Skeleton_LThumb2 l_finger:1:3
Skeleton_LIndex1 Skeleton_LHand l_finger:2:1
Skeleton_LIndex2 Skeleton_LIndex1 l_finger:2:2
Skeleton_LIndex3 Skeleton_LIndex2 l_finger:2:3
Skeleton_LMiddle1 Skeleton_LHand l_finger:3:1
Skeleton_LMiddle2 Skeleton_LMiddle1 l_finger:3:2
Skeleton_LMiddle3 Skeleton_LMiddle2 l_finger:3:3
Skeleton_RShoulder Skeleton_Chest r_clavicle
Skeleton_RUArm Skeleton_RShoulder r_shoulder
Skeleton_RFArm Skeleton_RUArm r_elbow
Skeleton_RHand Skeleton_RFArm r_wrist
Skeleton_RThumb1 Skeleton_RHand r_finger:1:1
Skeleton_RThumb2 Skeleton_RThumb1 r_finger:1:2
Skeleton_RThumb3 Skeleton_RThumb2 r_finger:1:3
Skeleton_RIndex1 Skeleton_RHand r_finger:2:1
Skeleton_RIndex2 Skeleton_RIndex1 r_finger:2:2
Skeleton_RIndex3 Skeleton_RIndex2 r_finger:2:3
Skeleton_RMiddle1 Skeleton_RHand r_finger:3:1
Skeleton_RMiddle2 Skeleton_RMiddle1 r_finger:3:2
Skeleton_RMiddle3 Skeleton_RMiddle2 r_finger:3:3
Skeleton_LThigh Skeleton_Hip l_hip
Skeleton_LShin Skeleton_LThigh l_knee
Skeleton_LFoot Skeleton_LShin l_ankle
Skeleton_LToe Skeleton_LFoot l_toe
Skeleton_RThigh Skeleton_Hip r_hip
Skeleton_RShin Skeleton_RThigh r_knee
Skeleton_RFoot Skeleton_RShin r_ankle
Skeleton_RToe Skeleton_RFoot r_toe

convention optitrack_motive_motionbuilder_names
kind joints
Skeleton_001_Hips - pelvis
Skeleton_001_Spine Skeleton_001_Hips spine:0.15
Skeleton_001_Spine1 Skeleton_001_Spine spine:0.5
Skeleton_001_Neck Skeleton_001_Spine1 neck
Skeleton_001_Head Skeleton_001_Neck head
Skeleton_001_LeftShoulder Skeleton_001_Spine1 l_clavicle
Skeleton_001_LeftArm Skeleton_001_LeftShoulder l_shoulder
Skeleton_001_LeftForeArm Skeleton_001_LeftArm l_elbow
Skeleton_001_LeftHand Skeleton_001_LeftForeArm l_wrist
Skeleton_001_RightShoulder Skeleton_001_Spine1 r_clavicle
Skeleton_001_RightArm Skeleton_001_RightShoulder r_shoulder
Skeleton_001_RightForeArm Skeleton_001_RightArm r_elbow
Skeleton_001_RightHand Skeleton_001_RightForeArm r_wrist
Skeleton_001_LeftUpLeg Skeleton_001_Hips l_hip
Skeleton_001_LeftLeg Skeleton_001_LeftUpLeg l_knee
Skeleton_001_LeftFoot Skeleton_001_LeftLeg l_ankle
Skeleton_001_LeftToeBase Skeleton_001_LeftFoot l_toe
Skeleton_001_RightUpLeg Skeleton_001_Hips r_hip
Skeleton_001_RightLeg Skeleton_001_RightUpLeg r_knee
Skeleton_001_RightFoot Skeleton_001_RightLeg r_ankle
Skeleton_001_RightToeBase Skeleton_001_RightFoot r_toe

convention vicon_blade
kind joints
Hips - pelvis
Spine Hips spine:0.15
Spine1 Spine spine:0.35
Spine2 Spine1 spine:0.54
Spine3 Spine2 spine:0.74
Neck Spine3 neck
Neck1 Neck between:neck:head:0.5
Head Neck1 head
HeadEnd Head head_top
LeftShoulder Spine3 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandEnd LeftHand l_hand
RightShoulder Spine3 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandEnd RightHand r_hand
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
LeftToeBaseEnd LeftToeBase l_toe_tip
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
RightToeBaseEnd RightToeBase r_toe_tip

convention vicon_shogun_solving
kind joints
Solving:Hips - pelvis
Solving:Spine Solving:Hips spine:0.15
Solving:Spine1 Solving:Spine spine:0.35
Solving:Spine2 Solving:Spine1 spine:0.54
Solving:Spine3 Solving:Spine2 spine:0.74
Solving:Neck Solving:Spine3 neck
Solving:Neck1 Solving:Neck between:neck:head:0.5
Solving:Head Solving:Neck1 head
Solving:LeftShoulder Solving:Spine3 l_clavicle
Solving:LeftArm Solving:LeftShoulder l_shoulder
Solving:LeftForeArm Solving:LeftArm l_elbow
Solving:LeftHand Solving:LeftForeArm l_wrist
Solving:LeftHandThumb1 Solving:LeftHand l_finger:1:1
Solving:LeftHandThumb2 Solving:LeftHandThumb1 l_finger:1:2
Solving:LeftHandThumb3 Solving:LeftHandThumb2 l_finger:1:3
Solving:LeftHandIndex1 Solving:LeftHand l_finger:2:1
Solving:LeftHandIndex2 Solving:LeftHandIndex1 l_finger:2:2
Solving:LeftHandIndex3 Solving:LeftHandIndex2 l_finger:2:3
Solving:LeftHandMiddle1 Solving:LeftHand l_finger:3:1
Solving:LeftHandMiddle2 Solving:LeftHandMiddle1 l_finger:3:2
Solving:LeftHandMiddle3 Solving:LeftHandMiddle2 l_finger:3:3
Solving:RightShoulder Solving:Spine3 r_clavicle
Solving:RightArm Solving:RightShoulder r_shoulder
Solving:RightForeArm Solving:RightArm r_elbow
Solving:RightHand Solving:RightForeArm r_wrist
Solving:RightHandThumb1 Solving:RightHand r_finger:1:1
Solving:RightHandThumb2 Solving:RightHandThumb1 r_finger:1:2
Solving:RightHandThumb3 Solving:RightHandThumb2 r_finger:1:3
Solving:RightHandIndex1 Solving:RightHand r_finger:2:1
Solving:RightHandIndex2 Solving:RightHandIndex1 r_finger:2:2
Solving:RightHandIndex3 Solving:RightHandIndex2 r_finger:2:3
Solving:RightHandMiddle1 Solving:RightHand r_finger:3:1
Solving:RightHandMiddle2 Solving:RightHandMiddle1 r_finger:3:2
Solving:RightHandMiddle3 Solving:RightHandMiddle2 r_finger:3:3
Solving:LeftUpLeg Solving:Hips l_hip
Solving:LeftLeg Solving:LeftUpLeg l_knee
Solving:LeftFoot Solving:LeftLeg l_ankle
Solving:LeftToeBase Solving:LeftFoot l_toe
Solving:RightUpLeg Solving:Hips r_hip
Solving:RightLeg Solving:RightUpLeg r_knee
Solving:RightFoot Solving:RightLeg r_ankle
Solving:RightToeBase Solving:RightFoot r_toe

convention vicon_nexus_plug_in_gait_segments
kind joints
Pelvis - pelvis
LFemur Pelvis l_hip
LTibia LFemur l_knee
LFoot LTibia l_ankle
LToes LFoot l_toe
RFemur Pelvis r_hip
RTibia RFemur r_knee
RFoot RTibia r_ankle
RToes RFoot r_toe
Thorax Pelvis spine:0.4
Head Thorax head
LClavicle Thorax l_clavicle
LHumerus LClavicle l_shoulder
LRadius LHumerus l_elbow
LHand LRadius l_wrist
RClavicle Thorax r_clavicle
RHumerus RClavicle r_shoulder
RRadius RHumerus r_elbow
RHand RRadius r_wrist

convention captury_29
kind joints
Hips - pelvis
Spine Hips spine:0.1
Spine1 Spine spine:0.25
Spine2 Spine1 spine:0.42
Spine3 Spine2 spine:0.6
Spine4 Spine3 spine:0.8
Neck Spine4 neck
Head Neck head
HeadEE Head head_top
LeftShoulder Spine4 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandEE LeftHand l_hand
RightShoulder Spine4 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandEE RightHand r_hand
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
LeftFootEE LeftToeBase l_toe_tip
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
RightFootEE RightToeBase r_toe_tip

convention captury_fingers_root
kind joints
Root - origin
Hips Root pelvis
Spine Hips spine:0.1
Spine1 Spine spine:0.25
Spine2 Spine1 spine:0.42
Spine3 Spine2 spine:0.6
Spine4 Spine3 spine:0.8
Neck Spine4 neck
Head Neck head
HeadEE Head head_top
LeftShoulder Spine4 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftHand LeftForeArm l_wrist
LeftHandThumb1 LeftHand l_finger:1:1
LeftHandThumb2 LeftHandThumb1 l_finger:1:2
LeftHandThumb3 LeftHandThumb2 l_finger:1:3
LeftHandIndex1 LeftHand l_finger:2:1
LeftHandIndex2 LeftHandIndex1 l_finger:2:2
LeftHandIndex3 LeftHandIndex2 l_finger:2:3
LeftHandMiddle1 LeftHand l_finger:3:1
LeftHandMiddle2 LeftHandMiddle1 l_finger:3:2
LeftHandMiddle3 LeftHandMiddle2 l_finger:3:3
LeftHandEE LeftHand l_hand
RightShoulder Spine4 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightHand RightForeArm r_wrist
RightHandThumb1 RightHand r_finger:1:1
RightHandThumb2 RightHandThumb1 r_finger:1:2
RightHandThumb3 RightHandThumb2 r_finger:1:3
RightHandIndex1 RightHand r_finger:2:1
RightHandIndex2 RightHandIndex1 r_finger:2:2
RightHandIndex3 RightHandIndex2 r_finger:2:3
RightHandMiddle1 RightHand r_finger:3:1
RightHandMiddle2 RightHandMiddle1 r_finger:3:2
RightHandMiddle3 RightHandMiddle2 r_finger:3:3
RightHandEE RightHand r_hand
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
LeftFootEE LeftToeBase l_toe_tip
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
RightFootEE RightToeBase r_toe_tip

convention qualisys_skeleton
kind joints
Hips - pelvis
LeftUpLeg Hips l_hip
LeftLeg LeftUpLeg l_knee
LeftFoot LeftLeg l_ankle
LeftToeBase LeftFoot l_toe
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle
RightToeBase RightFoot r_toe
Spine Hips spine:0.2
Spine1 Spine spine:0.45
Spine2 Spine1 spine:0.7
Neck Spine2 neck
Head Neck head
LeftShoulder Spine2 l_clavicle
LeftArm LeftShoulder l_shoulder
LeftForeArm LeftArm l_elbow
LeftForeArmRoll LeftForeArm between:l_elbow:l_wrist:0.5
LeftHand LeftForeArmRoll l_wrist
RightShoulder Spine2 r_clavicle
RightArm RightShoulder r_shoulder
RightForeArm RightArm r_elbow
RightForeArmRoll RightForeArm between:r_elbow:r_wrist:0.5
RightHand RightForeArmRoll r_wrist

convention ipi_mocap_studio
kind joints
Hip - pelvis
RThigh Hip r_hip
RShin RThigh r_knee
RFoot RShin r_ankle
RToe RFoot r_toe
LThigh Hip l_hip
LShin LThigh l_knee
LFoot LShin l_ankle
LToe LFoot l_toe
LowerSpine Hip spine:0.15
MiddleSpine LowerSpine spine:0.4
Chest MiddleSpine spine:0.65
Neck Chest neck
Head Neck head
RClavicle Chest r_clavicle
RShoulder RClavicle r_shoulder
RForearm RShoulder r_elbow
RHand RForearm r_wrist
LClavicle Chest l_clavicle
LShoulder LClavicle l_shoulder
LForearm LShoulder l_elbow
LHand LForearm l_wrist

convention kinect_bvh_hips
kind joints
Hips - pelvis
Spine Hips spine:0.3
Spine1 Spine spine:0.65
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
RightUpLeg Hips r_hip
RightLeg RightUpLeg r_knee
RightFoot RightLeg r_ankle

convention kinect_bvh_poser_names
kind joints
hip - pelvis
abdomen hip spine:0.3
chest abdomen spine:0.65
neck chest neck
head neck head
lCollar chest l_clavicle
lShldr lCollar l_shoulder
lForeArm lShldr l_elbow
lHand lForeArm l_wrist
rCollar chest r_clavicle
rShldr rCollar r_shoulder
rForeArm rShldr r_elbow
rHand rForeArm r_wrist
lThigh hip l_hip
lShin lThigh l_knee
lFoot lShin l_ankle
rThigh hip r_hip
rShin rThigh r_knee
rFoot rShin r_ankle

convention biovision_classic
kind joints
Hips - pelvis
LeftHip Hips l_hip
LeftKnee LeftHip l_knee
LeftAnkle LeftKnee l_ankle
RightHip Hips r_hip
RightKnee RightHip r_knee
RightAnkle RightKnee r_ankle
Chest Hips spine:0.28
LeftCollar Chest l_clavicle
LeftShoulder LeftCollar l_shoulder
LeftElbow LeftShoulder l_elbow
LeftWrist LeftElbow l_wrist
RightCollar Chest r_clavicle
RightShoulder RightCollar r_shoulder
RightElbow RightShoulder r_elbow
RightWrist RightElbow r_wrist
Neck Chest neck
Head Neck head
)";
  return kTable;
}

}  // namespace motiondb::tests
