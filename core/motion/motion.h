// Skeletons, and recorded motion before conversion to states: joint angles on a skeleton, or marker
// positions.
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"

namespace motiondb::core {

// One degree of freedom of a joint: a translation along, or a rotation about, a unit axis.
struct Dof {
  enum class Kind { kTranslation, kRotation };
  Kind kind = Kind::kRotation;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();          // translations: in the parent's frame
  double lower = -std::numeric_limits<double>::infinity();  // rad or m; infinite: unlimited
  double upper = std::numeric_limits<double>::infinity();
};

// The transform from a joint's frame to its parent's (the world's for a root) is
//   T(offset_m + sum t_k axis_k) * pre_rotation * R(axis_1, q_1) * R(axis_2, q_2) ... *
//   post_rotation
// Translations are summed. Rotations apply in the order of `dofs`, leftmost first.
//   BVH:  pre = post = identity.
//   ASF:  pre = C (the bone's `axis`), post = C^-1, so that zero angles do not rotate links.
//   URDF: pre = the origin's rpy, post = identity.
// A root's offset, translation axes and pre_rotation also convert the file's axes to the world
// (metres, z up). The frames of all other joints are as in the file.
struct Joint {
  std::string name;
  int parent = -1;  // index of a joint that precedes this one; -1 for a root
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d pre_rotation = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d post_rotation = Eigen::Matrix3d::Identity();
  std::vector<Dof> dofs = {};  // translations before rotations
};

// A tree of joints, each with an offset from its parent and degrees of freedom: the common form of
// ASF, BVH and URDF. Immutable after Create.
class Skeleton {
 public:
  // INVALID_ARGUMENT if there is no joint, a parent does not precede its child, names repeat, an
  // axis does not have unit length, a translation follows a rotation, or a number is not finite.
  static absl::StatusOr<Skeleton> Create(std::string name, std::vector<Joint> joints);

  const std::string& name() const { return name_; }
  const std::vector<Joint>& joints() const { return joints_; }
  int joint_count() const { return static_cast<int>(joints_.size()); }
  // Number of degrees of freedom: the columns of a JointMatrix on this skeleton.
  int dof_count() const { return dof_count_; }
  // Column of the joint's first degree of freedom.
  int first_dof(int joint) const { return first_dof_[joint]; }
  // Index of the joint with this name, or -1. O(joints).
  int FindJoint(std::string_view name) const;

 private:
  std::string name_;
  std::vector<Joint> joints_;
  std::vector<int> first_dof_;
  int dof_count_ = 0;
};

// Joint angles (rad) and translations (m) of a skeleton over time.
struct JointMotion {
  std::shared_ptr<const Skeleton> skeleton;
  double frame_rate_hz = 0;
  JointMatrix angles;  // frames x skeleton->dof_count()
};

// Marker positions in the world (m, z up) over time. A missing marker has NaN in all three columns.
struct MarkerMotion {
  std::vector<std::string> names;
  double frame_rate_hz = 0;
  FrameMatrix positions_m;  // frames x 3 * names.size(), x y z of each marker in turn
  int first_frame = 0;      // in the file, from 0; for messages
};

// A range of frames, counted from 0; first and last are included.
struct FrameSpan {
  int first = 0;
  int last = 0;
  friend bool operator==(const FrameSpan&, const FrameSpan&) = default;
};

using Motion = std::variant<JointMotion, MarkerMotion>;

}  // namespace motiondb::core
