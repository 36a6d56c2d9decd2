// The HIERARCHY section of a BVH file: joints, their offsets and channels, unconverted.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/format/text_scanner.h"
#include "core/motion/motion.h"

namespace motiondb::core {

// Characters that are separate tokens in a BVH file.
inline constexpr std::string_view kBvhPunctuation = "{}:";

struct BvhChannel {
  Dof::Kind kind = Dof::Kind::kRotation;
  int axis = 0;  // 0 x, 1 y, 2 z
};

struct BvhJoint {
  std::string name;
  int parent = -1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // in the file's unit
  std::vector<BvhChannel> channels;                  // in the file's order
  bool is_end_site = false;
};

// Reads up to and including the word MOTION. Joint names are unique UTF-8; end sites are named
// "<parent>_end". Appends changes of names to `notes`.
absl::StatusOr<std::vector<BvhJoint>> ReadBvhHierarchy(TextScanner& scanner,
                                                       std::vector<std::string>& notes);

}  // namespace motiondb::core
