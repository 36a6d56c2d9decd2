// Points of a pose estimator for cameras, on a motion of the standard markers.
#pragma once

#include <utility>

namespace motiondb::tests {

// The points of COCO (17), and the standard markers in their places.
inline constexpr std::pair<const char*, const char*> kCameraPoints[] = {
    {"nose", "HeadTop"},      {"left_eye", "HeadTop"},         {"right_eye", "HeadTop"},
    {"left_ear", "Head"},     {"right_ear", "Head"},           {"left_shoulder", "LShoulder"},
    {"left_elbow", "LElbow"}, {"right_shoulder", "RShoulder"}, {"right_elbow", "RElbow"},
    {"left_wrist", "LWrist"}, {"right_wrist", "RWrist"},       {"left_hip", "LHip"},
    {"right_hip", "RHip"},    {"left_knee", "LKnee"},          {"right_knee", "RKnee"},
    {"left_ankle", "LAnkle"}, {"right_ankle", "RAnkle"}};

}  // namespace motiondb::tests
