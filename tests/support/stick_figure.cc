#include "tests/support/stick_figure.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace motiondb::tests {
namespace {

constexpr char kHierarchy[] = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftUpLeg
  {
    OFFSET 9 -4 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftLeg
    {
      OFFSET 0 -42 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT LeftFoot
      {
        OFFSET 0 -40 0
        CHANNELS 3 Zrotation Xrotation Yrotation
        End Site
        {
          OFFSET 0 -8 14
        }
      }
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -9 -4 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightLeg
    {
      OFFSET 0 -42 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT RightFoot
      {
        OFFSET 0 -40 0
        CHANNELS 3 Zrotation Xrotation Yrotation
        End Site
        {
          OFFSET 0 -8 14
        }
      }
    }
  }
  JOINT Spine
  {
    OFFSET 0 20 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightArm
    {
      OFFSET -18 28 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -55 0
      }
    }
    JOINT Head
    {
      OFFSET 0 40 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 18 0
      }
    }
  }
}
)";

struct Pose {
  double forward_cm = 0;
  double height_cm = 94;
  double left_hip = 0;  // degrees about x, as the following angles
  double left_knee = 0;
  double right_hip = 0;
  double right_knee = 0;
  double arm = 0;  // about z
};

Pose PoseAt(const StickFigure& figure, double seconds) {
  const double angle = 2 * std::numbers::pi * figure.tempo * seconds + figure.phase;
  const double swing = std::sin(angle);
  Pose pose;
  switch (figure.act) {
    case Act::kWalk:
      pose.forward_cm = 130 * seconds;
      pose.height_cm += 2 * std::cos(2 * angle);
      pose.left_hip = -25 * swing;
      pose.right_hip = 25 * swing;
      pose.left_knee = 20 * (1 + std::cos(angle));
      pose.right_knee = 20 * (1 - std::cos(angle));
      break;
    case Act::kSquat:
      pose.height_cm -= 20 * (1 + swing);
      pose.left_hip = pose.right_hip = -40 * (1 + swing);
      pose.left_knee = pose.right_knee = 80 * (1 + swing);
      break;
    case Act::kWave:
      pose.arm = -90 - 60 * swing;
      break;
  }
  return pose;
}

}  // namespace

std::string WriteBvh(const StickFigure& figure) {
  std::string text = kHierarchy;
  text += fmt::format("MOTION\nFrames: {}\nFrame Time: {:.9f}\n", figure.frame_count,
                      1 / figure.frame_rate_hz);
  for (int frame = 0; frame < figure.frame_count; ++frame) {
    const Pose pose = PoseAt(figure, frame / figure.frame_rate_hz);
    text += fmt::format("0 {:.5f} {:.5f} 0 0 0", pose.height_cm, pose.forward_cm);
    text += fmt::format(" 0 {:.5f} 0 0 {:.5f} 0 0 0 0", pose.left_hip, pose.left_knee);
    text += fmt::format(" 0 {:.5f} 0 0 {:.5f} 0 0 0 0", pose.right_hip, pose.right_knee);
    text += fmt::format(" 0 0 0 {:.5f} 0 0 0 0 0\n", pose.arm);
  }
  return text;
}

}  // namespace motiondb::tests
