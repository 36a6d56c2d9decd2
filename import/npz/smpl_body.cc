#include "import/npz/smpl_body.h"

#include <array>
#include <cstddef>

namespace motiondb::importer {
namespace {

constexpr double kHipHeight = 0.530;
constexpr double kKneeHeight = 0.285;
constexpr double kAnkleHeight = 0.039;
constexpr double kShoulderHeight = 0.818;
constexpr double kEyeHeight = 0.936;
constexpr double kUpperArm = 0.186;
constexpr double kForearm = 0.146;
constexpr double kHand = 0.108;
constexpr double kFoot = 0.152;

constexpr double kHipWidth = 0.05;       // from the middle
constexpr double kShoulderWidth = 0.10;  // from the middle
constexpr double kWrist = kShoulderWidth + kUpperArm + kForearm;
constexpr double kBall = 0.45 * kFoot;  // ball of the foot, in front of the ankle

constexpr std::size_t kBodyJoints = 22;
constexpr int kHead = 15;
constexpr int kLeftWrist = 20;

struct PlainJoint {
  std::string_view name;
  int parent;
  double x, y, z;
};

// The joints that all models share.
constexpr std::array<PlainJoint, kBodyJoints> kBody = {{
    {"pelvis", -1, 0, kHipHeight + 0.05, 0},
    {"left_hip", 0, kHipWidth, kHipHeight, 0},
    {"right_hip", 0, -kHipWidth, kHipHeight, 0},
    {"spine1", 0, 0, 0.640, 0},
    {"left_knee", 1, kHipWidth, kKneeHeight, 0},
    {"right_knee", 2, -kHipWidth, kKneeHeight, 0},
    {"spine2", 3, 0, 0.710, 0},
    {"left_ankle", 4, kHipWidth, kAnkleHeight, 0},
    {"right_ankle", 5, -kHipWidth, kAnkleHeight, 0},
    {"spine3", 6, 0, 0.745, 0},
    {"left_foot", 7, kHipWidth, 0.012, kBall},
    {"right_foot", 8, -kHipWidth, 0.012, kBall},
    {"neck", 9, 0, 0.850, 0},
    {"left_collar", 9, 0.045, 0.805, 0},
    {"right_collar", 9, -0.045, 0.805, 0},
    {"head", 12, 0, 0.900, 0.01},
    {"left_shoulder", 13, kShoulderWidth, kShoulderHeight, 0},
    {"right_shoulder", 14, -kShoulderWidth, kShoulderHeight, 0},
    {"left_elbow", 16, kShoulderWidth + kUpperArm, kShoulderHeight, 0},
    {"right_elbow", 17, -kShoulderWidth - kUpperArm, kShoulderHeight, 0},
    {"left_wrist", 18, kWrist, kShoulderHeight, 0},
    {"right_wrist", 19, -kWrist, kShoulderHeight, 0},
}};

constexpr std::array<PlainJoint, 2> kSmplHands = {{
    {"left_hand", 20, kWrist + 0.5 * kHand, kShoulderHeight, 0},
    {"right_hand", 21, -kWrist - 0.5 * kHand, kShoulderHeight, 0},
}};

constexpr std::array<PlainJoint, 3> kFace = {{
    {"jaw", kHead, 0, 0.895, 0.015},
    {"left_eye_smplhf", kHead, 0.018, kEyeHeight, 0.055},
    {"right_eye_smplhf", kHead, -0.018, kEyeHeight, 0.055},
}};

// The joints of a finger, in hand lengths from the wrist: outwards and to the thumb's side.
struct Finger {
  std::array<std::string_view, 2> names[3];  // left, right
  std::array<double, 3> outwards;
  std::array<double, 3> sideways;
};

constexpr std::array<Finger, 5> kFingers = {{
    {{{"left_index1", "right_index1"},
      {"left_index2", "right_index2"},
      {"left_index3", "right_index3"}},
     {0.48, 0.70, 0.83},
     {0.11, 0.13, 0.14}},
    {{{"left_middle1", "right_middle1"},
      {"left_middle2", "right_middle2"},
      {"left_middle3", "right_middle3"}},
     {0.50, 0.74, 0.89},
     {0, 0, 0}},
    {{{"left_pinky1", "right_pinky1"},
      {"left_pinky2", "right_pinky2"},
      {"left_pinky3", "right_pinky3"}},
     {0.42, 0.59, 0.69},
     {-0.20, -0.23, -0.25}},
    {{{"left_ring1", "right_ring1"}, {"left_ring2", "right_ring2"}, {"left_ring3", "right_ring3"}},
     {0.47, 0.69, 0.83},
     {-0.10, -0.12, -0.13}},
    {{{"left_thumb1", "right_thumb1"},
      {"left_thumb2", "right_thumb2"},
      {"left_thumb3", "right_thumb3"}},
     {0.14, 0.30, 0.43},
     {0.13, 0.26, 0.35}},
}};

template <std::size_t kCount>
void AddJoints(const std::array<PlainJoint, kCount>& added, std::vector<SmplJoint>& joints) {
  for (const PlainJoint& joint : added) {
    joints.push_back(
        {.name = joint.name, .parent = joint.parent, .rest = {joint.x, joint.y, joint.z}});
  }
}

void AddFingers(std::vector<SmplJoint>& joints) {
  for (const int side : {0, 1}) {
    const double outwards = side == 0 ? kHand : -kHand;
    for (const Finger& finger : kFingers) {
      int parent = kLeftWrist + side;
      for (int k = 0; k < 3; ++k) {
        joints.push_back({.name = finger.names[k][side],
                          .parent = parent,
                          .rest = joints[kLeftWrist + side].rest +
                                  Eigen::Vector3d(outwards * finger.outwards[k], 0,
                                                  kHand * finger.sideways[k])});
        parent = static_cast<int>(joints.size()) - 1;
      }
    }
  }
}

}  // namespace

std::string_view NameOf(SmplModel model) {
  constexpr std::array<std::string_view, 3> kNames = {"SMPL", "SMPL-H", "SMPL-X"};
  return kNames[static_cast<std::size_t>(model)];
}

std::string_view NameOf(SmplGender gender) {
  constexpr std::array<std::string_view, 3> kNames = {"neutral", "female", "male"};
  return kNames[static_cast<std::size_t>(gender)];
}

std::vector<SmplJoint> SmplJoints(SmplModel model) {
  std::vector<SmplJoint> joints;
  AddJoints(kBody, joints);
  if (model == SmplModel::kSmpl) {
    AddJoints(kSmplHands, joints);
    return joints;
  }
  if (model == SmplModel::kSmplX) AddJoints(kFace, joints);
  AddFingers(joints);
  return joints;
}

double SmplStature(SmplGender gender) {
  constexpr std::array<double, 3> kStature_m = {1.69, 1.62, 1.75};
  return kStature_m[static_cast<std::size_t>(gender)];
}

Eigen::Vector3d SmplPelvis(SmplModel model) {
  return {0, model == SmplModel::kSmplX ? -0.35 : -0.22, 0};
}

}  // namespace motiondb::importer
