#include <algorithm>
#include <utility>

#include "core/format/asf_file.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

// Returns C of the bone: its axes in the common frame of all bones at zero angles.
Eigen::Matrix3d BoneAxes(const AsfBone& bone, double radians_per_angle) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(bone.axis_order[i]);
    axes = Eigen::AngleAxisd(bone.axis_angles[i] * radians_per_angle, axis) * axes;
  }
  return axes;
}

// Adds the degrees of freedom of a bone to its joint, and the column of each channel to `values`,
// in file order. ASF lists the rotation applied first first; Joint::dofs is the reverse.
void AddDofs(const AsfBone& bone, const Eigen::Matrix3d& translation_axes, double metres_per_unit,
             double radians_per_angle, int first_column, Joint& joint,
             std::vector<AmcValue>& values) {
  values.resize(bone.channels.size());
  const auto add = [&](std::size_t i, Dof::Kind kind, const Eigen::Vector3d& axis, double unit) {
    const AsfChannel& channel = bone.channels[i];
    values[i] = {.column = first_column + static_cast<int>(joint.dofs.size()),
                 .is_rotation = kind == Dof::Kind::kRotation};
    joint.dofs.push_back(
        {.kind = kind, .axis = axis, .lower = channel.lower * unit, .upper = channel.upper * unit});
  };
  for (std::size_t i = 0; i < bone.channels.size(); ++i) {
    if (bone.channels[i].kind != AsfChannel::Kind::kTranslation) continue;
    add(i, Dof::Kind::kTranslation, translation_axes.col(bone.channels[i].axis), metres_per_unit);
  }
  for (std::size_t i = bone.channels.size(); i-- > 0;) {
    if (bone.channels[i].kind != AsfChannel::Kind::kRotation) continue;
    add(i, Dof::Kind::kRotation, Eigen::Vector3d::Unit(bone.channels[i].axis), radians_per_angle);
  }
}

}  // namespace

absl::StatusOr<AsfSkeleton> BuildAsfSkeleton(const AsfFile& file, double metres_per_unit,
                                             const Eigen::Matrix3d& world_from_file) {
  const double radians_per_angle = file.degrees ? kRadiansPerDegree : 1;
  std::vector<Joint> joints;
  std::vector<AmcBone> bones;
  UniqueNames names;
  std::vector<bool> is_parent(file.bones.size(), false);
  int columns = 0;
  bool drops_stretch = false;
  for (const AsfBone& bone : file.bones) {
    const Eigen::Matrix3d axes = BoneAxes(bone, radians_per_angle);
    Joint joint{.name = names.Add(bone.name), .parent = bone.parent, .dofs = {}};
    AmcBone amc{.name = bone.name, .values = {}};
    joint.post_rotation = axes.transpose();
    if (bone.parent < 0) {
      joint.offset_m = world_from_file * file.root_position * metres_per_unit;
      joint.pre_rotation = world_from_file * axes;
      AddDofs(bone, world_from_file, metres_per_unit, radians_per_angle, columns, joint,
              amc.values);
    } else {
      const AsfBone& parent = file.bones[bone.parent];
      is_parent[bone.parent] = true;
      joint.offset_m = parent.direction * parent.length * metres_per_unit;
      joint.pre_rotation = axes;
      AddDofs(bone, axes, metres_per_unit, radians_per_angle, columns, joint, amc.values);
    }
    drops_stretch |= joint.dofs.size() < bone.channels.size();
    columns += static_cast<int>(joint.dofs.size());
    joints.push_back(std::move(joint));
    bones.push_back(std::move(amc));
  }
  for (std::size_t i = 1; i < file.bones.size(); ++i) {
    if (is_parent[i]) continue;
    const AsfBone& bone = file.bones[i];
    joints.push_back({.name = names.Add(bone.name + "_end"),
                      .parent = static_cast<int>(i),
                      .offset_m = bone.direction * bone.length * metres_per_unit,
                      .dofs = {}});
  }
  MOTIONDB_ASSIGN_OR_RETURN(
      Skeleton skeleton,
      Skeleton::Create(file.name.empty() ? "root" : file.name, std::move(joints)));
  return AsfSkeleton{std::move(skeleton), std::move(bones), drops_stretch};
}

}  // namespace motiondb::core
