// Standard markers of humanoid robots: mappings of standard34 in the marker-set file format
// (docs/file_formats.md), appended to the text in standard34.cc.
//
// A robot's trunk is mostly rigid. Waist, spine, neck, head and head top are at 44, 67, 90, 125 and
// 144 % of the way from its hips to its shoulders, as for the people of the CMU collection; head
// and head top are at the robot's own joints, if there are any.
#include "core/format/marker_set_file.h"

namespace motiondb::core {
namespace {

constexpr std::string_view kRobotText = R"(
# Unitree G1. The hips lie on the axes of the hips' pitch, in line with the axes of their roll.
# Heels and toes lie between the points that touch the floor.
mapping unitree-g1
signature left_hip_pitch_joint right_hip_pitch_joint left_knee_joint right_knee_joint
signature left_ankle_pitch_joint right_ankle_pitch_joint left_ankle_roll_joint right_ankle_roll_joint
signature waist_pitch_joint left_shoulder_pitch_joint right_shoulder_pitch_joint
signature left_shoulder_roll_joint right_shoulder_roll_joint left_elbow_joint right_elbow_joint
signature left_wrist_pitch_joint right_wrist_pitch_joint left_wrist_yaw_joint right_wrist_yaw_joint
Waist = 0.9 waist_pitch_joint + 0.05 left_shoulder_pitch_joint + 0.05 right_shoulder_pitch_joint
Spine = 0.54 waist_pitch_joint + 0.23 left_shoulder_pitch_joint + 0.23 right_shoulder_pitch_joint
Neck = 0.16 waist_pitch_joint + 0.42 left_shoulder_pitch_joint + 0.42 right_shoulder_pitch_joint
Head = -0.38 waist_pitch_joint + 0.69 left_shoulder_pitch_joint + 0.69 right_shoulder_pitch_joint
HeadTop = -0.68 waist_pitch_joint + 0.84 left_shoulder_pitch_joint + 0.84 right_shoulder_pitch_joint
LHip = 1.4 left_hip_pitch_joint + -0.4 right_hip_pitch_joint
LKnee = left_knee_joint
LAnkle = left_ankle_pitch_joint
LHeel = left_ankle_roll_joint offset left_ankle_roll_joint -0.079 0 -0.047
LToe = left_ankle_roll_joint offset left_ankle_roll_joint 0.188 0 -0.047
LShoulder = left_shoulder_roll_joint
LElbow = left_elbow_joint
LWrist = left_wrist_pitch_joint
LHand = left_wrist_yaw_joint offset left_wrist_yaw_joint 0.08 0 0
RHip = 1.4 right_hip_pitch_joint + -0.4 left_hip_pitch_joint
RKnee = right_knee_joint
RAnkle = right_ankle_pitch_joint
RHeel = right_ankle_roll_joint offset right_ankle_roll_joint -0.079 0 -0.047
RToe = right_ankle_roll_joint offset right_ankle_roll_joint 0.188 0 -0.047
RShoulder = right_shoulder_roll_joint
RElbow = right_elbow_joint
RWrist = right_wrist_pitch_joint
RHand = right_wrist_yaw_joint offset right_wrist_yaw_joint 0.08 0 0

# Unitree H1. Its legs are 11 cm outside of its hips. They are mapped as if below the hips, as on a
# person; otherwise a person's stance would tilt the soles, because the ankles have no roll joint.
# There is no wrist: the forearm has a person's length.
mapping unitree-h1
signature left_hip_roll_joint right_hip_roll_joint left_hip_pitch_joint right_hip_pitch_joint
signature left_knee_joint right_knee_joint left_ankle_joint right_ankle_joint torso_joint
signature left_shoulder_pitch_joint right_shoulder_pitch_joint left_shoulder_roll_joint
signature right_shoulder_roll_joint left_elbow_joint right_elbow_joint
Waist = 0.78 torso_joint + 0.11 left_shoulder_pitch_joint + 0.11 right_shoulder_pitch_joint
Spine = 0.44 torso_joint + 0.28 left_shoulder_pitch_joint + 0.28 right_shoulder_pitch_joint
Neck = 0.12 torso_joint + 0.44 left_shoulder_pitch_joint + 0.44 right_shoulder_pitch_joint
Head = -0.38 torso_joint + 0.69 left_shoulder_pitch_joint + 0.69 right_shoulder_pitch_joint
HeadTop = -0.64 torso_joint + 0.82 left_shoulder_pitch_joint + 0.82 right_shoulder_pitch_joint
LHip = left_hip_roll_joint
LKnee = left_knee_joint + left_hip_roll_joint + -1 left_hip_pitch_joint
LAnkle = left_ankle_joint + left_hip_roll_joint + -1 left_hip_pitch_joint
LHeel = left_ankle_joint + left_hip_roll_joint + -1 left_hip_pitch_joint offset left_ankle_joint -0.1125 0 -0.0625
LToe = left_ankle_joint + left_hip_roll_joint + -1 left_hip_pitch_joint offset left_ankle_joint 0.2375 0 -0.0625
LShoulder = left_shoulder_roll_joint
LElbow = left_elbow_joint
LForearm = left_elbow_joint offset left_elbow_joint 0.135 0 -0.01
LWrist = left_elbow_joint offset left_elbow_joint 0.27 0 -0.02
LHand = left_elbow_joint offset left_elbow_joint 0.37 0 -0.02
RHip = right_hip_roll_joint
RKnee = right_knee_joint + right_hip_roll_joint + -1 right_hip_pitch_joint
RAnkle = right_ankle_joint + right_hip_roll_joint + -1 right_hip_pitch_joint
RHeel = right_ankle_joint + right_hip_roll_joint + -1 right_hip_pitch_joint offset right_ankle_joint -0.1125 0 -0.0625
RToe = right_ankle_joint + right_hip_roll_joint + -1 right_hip_pitch_joint offset right_ankle_joint 0.2375 0 -0.0625
RShoulder = right_shoulder_roll_joint
RElbow = right_elbow_joint
RForearm = right_elbow_joint offset right_elbow_joint 0.135 0 -0.01
RWrist = right_elbow_joint offset right_elbow_joint 0.27 0 -0.02
RHand = right_elbow_joint offset right_elbow_joint 0.37 0 -0.02

# Boston Dynamics Atlas. The neck is at the height where the arms join the torso.
mapping atlas
signature back_bky back_bkx neck_ay l_leg_hpy r_leg_hpy l_leg_kny r_leg_kny l_leg_aky r_leg_aky
signature l_leg_akx r_leg_akx l_arm_shz r_arm_shz l_arm_shx r_arm_shx l_arm_elx r_arm_elx
signature l_arm_mwx r_arm_mwx l_arm_lwy r_arm_lwy
Waist = back_bky
Spine = 0.86 back_bkx + 0.07 l_arm_shz + 0.07 r_arm_shz
Neck = 0.5 l_arm_shz + 0.5 r_arm_shz
Head = neck_ay
HeadTop = neck_ay offset neck_ay 0 0 0.13
LHip = l_leg_hpy
LKnee = l_leg_kny
LAnkle = l_leg_aky
LHeel = l_leg_akx offset l_leg_akx -0.11 0 -0.096
LToe = l_leg_akx offset l_leg_akx 0.216 0 -0.096
LShoulder = l_arm_shx
LElbow = l_arm_elx
LWrist = l_arm_mwx
LHand = l_arm_lwy offset l_arm_lwy 0 -0.15 0
RHip = r_leg_hpy
RKnee = r_leg_kny
RAnkle = r_leg_aky
RHeel = r_leg_akx offset r_leg_akx -0.11 0 -0.096
RToe = r_leg_akx offset r_leg_akx 0.216 0 -0.096
RShoulder = r_arm_shx
RElbow = r_arm_elx
RWrist = r_arm_mwx
RHand = r_arm_lwy offset r_arm_lwy 0 -0.15 0

# JVRC-1. The file has no feet: they have a person's size, as for the simple humanoid.
mapping jvrc1
signature L_HIP_P R_HIP_P L_KNEE R_KNEE L_ANKLE_P R_ANKLE_P WAIST_R NECK_P L_SHOULDER_P R_SHOULDER_P
signature L_ELBOW_P R_ELBOW_P L_WRIST_R R_WRIST_R L_WRIST_Y R_WRIST_Y
Waist = 0.88 WAIST_R + 0.06 L_SHOULDER_P + 0.06 R_SHOULDER_P
Spine = 0.52 WAIST_R + 0.24 L_SHOULDER_P + 0.24 R_SHOULDER_P
Neck = 0.16 WAIST_R + 0.42 L_SHOULDER_P + 0.42 R_SHOULDER_P
Head = NECK_P
HeadTop = NECK_P offset NECK_P 0 0 0.143
LHip = L_HIP_P
LKnee = L_KNEE
LAnkle = L_ANKLE_P
LHeel = L_ANKLE_P offset L_ANKLE_P -0.06 0 -0.07
LToe = L_ANKLE_P offset L_ANKLE_P 0.16 0 -0.07
LShoulder = L_SHOULDER_P
LElbow = L_ELBOW_P
LWrist = L_WRIST_R
LHand = L_WRIST_Y offset L_WRIST_Y 0 0 -0.112
RHip = R_HIP_P
RKnee = R_KNEE
RAnkle = R_ANKLE_P
RHeel = R_ANKLE_P offset R_ANKLE_P -0.06 0 -0.07
RToe = R_ANKLE_P offset R_ANKLE_P 0.16 0 -0.07
RShoulder = R_SHOULDER_P
RElbow = R_ELBOW_P
RWrist = R_WRIST_R
RHand = R_WRIST_Y offset R_WRIST_Y 0 0 -0.112

# Nao. Its base is at the height of the waist.
mapping nao
signature base_link LHipRoll RHipRoll LKneePitch RKneePitch LAnklePitch RAnklePitch LAnkleRoll RAnkleRoll
signature HeadPitch LShoulderPitch RShoulderPitch LElbowRoll RElbowRoll LWristYaw RWristYaw LHand RHand
Waist = base_link
Spine = 0.6 base_link + 0.2 LShoulderPitch + 0.2 RShoulderPitch
Neck = 0.18 base_link + 0.41 LShoulderPitch + 0.41 RShoulderPitch
Head = HeadPitch
HeadTop = HeadPitch offset HeadPitch 0 0 0.31
LHip = LHipRoll
LKnee = LKneePitch
LAnkle = LAnklePitch
LHeel = LAnkleRoll offset LAnkleRoll -0.148 0 -0.222
LToe = LAnkleRoll offset LAnkleRoll 0.345 0 -0.222
LShoulder = LShoulderPitch
LElbow = LElbowRoll
LWrist = LWristYaw
LHand = LHand
RHip = RHipRoll
RKnee = RKneePitch
RAnkle = RAnklePitch
RHeel = RAnkleRoll offset RAnkleRoll -0.148 0 -0.222
RToe = RAnkleRoll offset RAnkleRoll 0.345 0 -0.222
RShoulder = RShoulderPitch
RElbow = RElbowRoll
RWrist = RWristYaw
RHand = RHand

# The simple humanoid of robot-dynamics examples. It has no head: a person's head on its trunk is used.
mapping simple-humanoid
signature LLEG_HIP_R RLEG_HIP_R LLEG_KNEE RLEG_KNEE LLEG_ANKLE_R RLEG_ANKLE_R WAIST_R CHEST
signature LARM_SHOULDER_P RARM_SHOULDER_P LARM_ELBOW RARM_ELBOW LARM_WRIST_R RARM_WRIST_R
Waist = 0.84 WAIST_R + 0.16 CHEST
Spine = 0.5 WAIST_R + 0.5 CHEST
Neck = 0.15 WAIST_R + 0.85 CHEST
Head = -0.38 WAIST_R + 1.38 CHEST
HeadTop = -0.66 WAIST_R + 1.66 CHEST
LHip = LLEG_HIP_R
LKnee = LLEG_KNEE
LAnkle = LLEG_ANKLE_R
LHeel = LLEG_ANKLE_R offset LLEG_ANKLE_R -0.06 0 -0.07
LToe = LLEG_ANKLE_R offset LLEG_ANKLE_R 0.16 0 -0.07
LShoulder = LARM_SHOULDER_P
LElbow = LARM_ELBOW
LWrist = LARM_WRIST_R
LHand = LARM_WRIST_R offset LARM_WRIST_R 0 0 -0.11
RHip = RLEG_HIP_R
RKnee = RLEG_KNEE
RAnkle = RLEG_ANKLE_R
RHeel = RLEG_ANKLE_R offset RLEG_ANKLE_R -0.06 0 -0.07
RToe = RLEG_ANKLE_R offset RLEG_ANKLE_R 0.16 0 -0.07
RShoulder = RARM_SHOULDER_P
RElbow = RARM_ELBOW
RWrist = RARM_WRIST_R
RHand = RARM_WRIST_R offset RARM_WRIST_R 0 0 -0.11
)";

}  // namespace

std::string_view Standard34RobotMappings() { return kRobotText; }

}  // namespace motiondb::core
