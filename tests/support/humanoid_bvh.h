// A synthetic person with all body parts, as a BVH file.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

namespace motiondb::tests {

// Returns a person of 1.7 m who swings legs and arms on the spot, y up. `scale`: units per metre.
inline std::string HumanoidBvh(double scale, int frame_count, bool lies = false) {
  struct Bone {
    const char* name;
    int depth;
    double x, y, z;  // m, from the parent
  };
  const std::vector<Bone> bones = {{"Hips", 0, 0, 0, 0},
                                   {"LeftUpLeg", 1, 0.09, -0.04, 0},
                                   {"LeftLeg", 2, 0, -0.42, 0},
                                   {"LeftFoot", 3, 0, -0.4, 0},
                                   {"LeftToeBase", 4, 0, -0.07, 0.14},
                                   {"RightUpLeg", 1, -0.09, -0.04, 0},
                                   {"RightLeg", 2, 0, -0.42, 0},
                                   {"RightFoot", 3, 0, -0.4, 0},
                                   {"RightToeBase", 4, 0, -0.07, 0.14},
                                   {"Spine", 1, 0, 0.12, 0},
                                   {"Spine1", 2, 0, 0.18, 0},
                                   {"Neck", 3, 0, 0.2, 0},
                                   {"Head", 4, 0, 0.1, 0.02},
                                   {"LeftShoulder", 3, 0.05, 0.16, 0},
                                   {"LeftArm", 4, 0.12, 0, 0},
                                   {"LeftForeArm", 5, 0.02, -0.28, 0},
                                   {"LeftHand", 6, 0, -0.25, 0},
                                   {"RightShoulder", 3, -0.05, 0.16, 0},
                                   {"RightArm", 4, -0.12, 0, 0},
                                   {"RightForeArm", 5, -0.02, -0.28, 0},
                                   {"RightHand", 6, 0, -0.25, 0}};
  std::string text = "HIERARCHY\n";
  const auto close_to = [&](int from, int to) {
    for (int depth = from; depth >= to; --depth) text += "}\n";
  };
  for (std::size_t i = 0; i < bones.size(); ++i) {
    const Bone& bone = bones[i];
    if (i > 0 && bones[i - 1].depth >= bone.depth) {
      text += "End Site\n{\nOFFSET 0 0 0\n}\n";
      close_to(bones[i - 1].depth, bone.depth);
    }
    text += fmt::format("{} {}\n{{\nOFFSET {} {} {}\nCHANNELS {}Zrotation Xrotation Yrotation\n",
                        i == 0 ? "ROOT" : "JOINT", bone.name, scale * bone.x, scale * bone.y,
                        scale * bone.z, i == 0 ? "6 Xposition Yposition Zposition " : "3 ");
  }
  text += "End Site\n{\nOFFSET 0 0 0\n}\n";
  close_to(bones.back().depth, 0);
  text += fmt::format("MOTION\nFrames: {}\nFrame Time: 0.0333333\n", frame_count);
  for (int frame = 0; frame < frame_count; ++frame) {
    text += fmt::format("0 {} 0", 0.93 * scale);
    const double swing = 20 * std::sin(0.2 * frame);
    for (std::size_t i = 0; i < bones.size(); ++i) {
      const std::string name = bones[i].name;
      const bool left = name == "LeftUpLeg" || name == "RightArm";
      const bool right = name == "RightUpLeg" || name == "LeftArm";
      text += fmt::format(" 0 {} 0", i == 0 && lies ? 90 : left ? swing : right ? -swing : 0);
    }
    text += '\n';
  }
  return text;
}

}  // namespace motiondb::tests
