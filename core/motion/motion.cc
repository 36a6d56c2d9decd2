#include "core/motion/motion.h"

#include <cmath>
#include <unordered_set>
#include <utility>

#include "core/motion/error.h"

namespace motiondb::core {
namespace {

absl::Status CheckJoint(const Joint& joint, int index) {
  if (joint.name.empty()) {
    return InvalidArgument("joint {} has no name", index);
  }
  if (joint.parent < -1 || joint.parent >= index) {
    return InvalidArgument("joint '{}': expected its parent before it", joint.name);
  }
  if (!joint.offset_m.allFinite() || !joint.pre_rotation.allFinite() ||
      !joint.post_rotation.allFinite()) {
    return InvalidArgument("joint '{}': offset or rotation is not finite", joint.name);
  }
  bool rotated = false;
  for (const Dof& dof : joint.dofs) {
    if (!(std::abs(dof.axis.norm() - 1.0) < 1e-6)) {
      return InvalidArgument("joint '{}': expected axes of length 1", joint.name);
    }
    if (std::isnan(dof.lower) || std::isnan(dof.upper) || dof.lower > dof.upper) {
      return InvalidArgument("joint '{}': expected lower limit <= upper limit", joint.name);
    }
    if (dof.kind == Dof::Kind::kTranslation && rotated) {
      return InvalidArgument("joint '{}': expected translations before rotations", joint.name);
    }
    rotated |= dof.kind == Dof::Kind::kRotation;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Skeleton> Skeleton::Create(std::string name, std::vector<Joint> joints) {
  if (joints.empty()) return InvalidArgument("a skeleton needs at least one joint");
  Skeleton skeleton;
  std::unordered_set<std::string_view> names;
  for (int j = 0; j < static_cast<int>(joints.size()); ++j) {
    MOTIONDB_RETURN_IF_ERROR(CheckJoint(joints[j], j));
    if (!names.insert(joints[j].name).second) {
      return InvalidArgument("two joints are named '{}'", joints[j].name);
    }
    skeleton.first_dof_.push_back(skeleton.dof_count_);
    skeleton.dof_count_ += static_cast<int>(joints[j].dofs.size());
  }
  skeleton.name_ = std::move(name);
  skeleton.joints_ = std::move(joints);
  return skeleton;
}

int Skeleton::FindJoint(std::string_view name) const {
  for (int j = 0; j < joint_count(); ++j) {
    if (joints_[j].name == name) return j;
  }
  return -1;
}

}  // namespace motiondb::core
