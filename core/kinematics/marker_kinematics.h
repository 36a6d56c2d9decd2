// Positions of a scheme's virtual markers on a skeleton, and their Jacobian. Immutable after
// Create.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/marker_set.h"
#include "core/motion/motion.h"

namespace motiondb::core {

struct BoundRule;

// A pose with derived values; the caller's storage, made by MarkerKinematics::NewPose.
struct MarkerPose {
  Eigen::RowVectorXd angles;  // 1 x dof_count, rad and m
  std::vector<Eigen::Isometry3d> world_from_joint;
  Eigen::Matrix3Xd markers_m;  // 3 x marker_count, world
  // After Differentiate: the world axis of each velocity coordinate, and the nonzero entries of the
  // Jacobian: for marker m, one column for each of Coordinates(m).
  std::vector<Eigen::Vector3d> axes;
  Eigen::Matrix3Xd jacobian;
};

// A pose has dof_count velocity coordinates. They are the rates of the degrees of freedom, except
// for joints with free rotation: three unlimited rotations about perpendicular axes. Their
// coordinates are the angular velocity (rad/s) relative to the parent, along the world's x, y and
// z. So a free root has no gimbal lock, and eq. 9 yields the root's angular velocity.
class MarkerKinematics {
 public:
  // `leg_length_m` scales the mapping's offsets; default: SkeletonLegLength. INVALID_ARGUMENT if no
  // mapping of the scheme fits the skeleton.
  static absl::StatusOr<MarkerKinematics> Create(const MarkerScheme& scheme,
                                                 std::shared_ptr<const Skeleton> skeleton,
                                                 std::optional<double> leg_length_m = std::nullopt);

  const std::shared_ptr<const Skeleton>& skeleton() const { return skeleton_; }
  const std::vector<std::string>& marker_names() const { return marker_names_; }
  int marker_count() const { return static_cast<int>(marker_names_.size()); }
  int dof_count() const { return skeleton_->dof_count(); }

  // The coordinates that move a marker, ascending, and their first column in the Jacobian.
  std::span<const int> Coordinates(int marker) const;
  int first_column(int marker) const { return first_column_[marker]; }
  bool TurnsFreely(int joint) const { return turns_freely_[joint]; }
  bool IsRotation(int coordinate) const { return is_rotation_[coordinate]; }

  // Returns storage for one pose: zero angles, not placed.
  MarkerPose NewPose() const;
  // Computes joints and markers from pose.angles. Does not allocate.
  void Place(MarkerPose& pose) const;
  // Computes axes and Jacobian of a placed pose. Does not allocate.
  void Differentiate(MarkerPose& pose) const;
  // Sets to.angles to from.angles advanced by `step` (1 x dof_count: velocity coordinates for one
  // unit of time). Ignores limits. Does not allocate. `from` must be placed.
  void Advance(const MarkerPose& from, const Eigen::Ref<const Eigen::VectorXd>& step,
               MarkerPose& to) const;
  // Unwraps the pose's angles: of all angles that mean the same pose, including the two solutions
  // of a free rotation, chooses those nearest to `angles` (1 x dof_count). Does not allocate.
  // `pose` must be placed.
  void UnwrapAngles(const Eigen::RowVectorXd& angles, MarkerPose& pose) const;

 private:
  // One term of a marker: a weighted joint origin, or an offset in a joint's frame (m).
  struct Term {
    int marker;
    int joint;
    double weight;
    Eigen::Vector3d offset_m;
    bool is_offset;
  };
  // The effect of one coordinate on one term, added to `column` of the Jacobian.
  struct Influence {
    int term;
    int coordinate;
    int column;
  };

  MarkerKinematics() = default;
  void AddTerms(const BoundRule& rule, double leg_length_m, int marker);
  void AddInfluences();
  // Returns the angles of a joint with free rotation for this rotation in the world, nearest to
  // `previous`.
  Eigen::Vector3d FreeAngles(int joint, const Eigen::Matrix3d& world_from_joint,
                             const MarkerPose& pose, const Eigen::Vector3d& previous) const;
  // Calls visit(coordinate) for all coordinates that move the term.
  template <typename Visit>
  void ForEachCoordinate(const Term& term, Visit visit) const;

  std::shared_ptr<const Skeleton> skeleton_;
  std::vector<std::string> marker_names_;
  std::vector<bool> turns_freely_;  // of each joint
  std::vector<int> joint_of_;       // of each coordinate
  std::vector<bool> is_rotation_;   // of each coordinate
  std::vector<Term> terms_;         // by marker
  std::vector<int> coordinates_;    // of all markers, concatenated
  std::vector<int> first_column_;   // of each marker in coordinates_, and the end
  std::vector<Influence> influences_;
};

// Limits of a skeleton's degrees of freedom: 1 x dof_count each, rad and m; infinite: no limit.
struct JointLimits {
  Eigen::RowVectorXd lower;
  Eigen::RowVectorXd upper;
};

JointLimits LimitsOf(const Skeleton& skeleton);
// Returns infinite limits.
JointLimits NoLimits(const Skeleton& skeleton);

// Returns the number of angles (frames x dof_count) that exceed the skeleton's limits by more than
// `tolerance` (rad or m), or are not finite.
int CountLimitViolations(const JointMotion& motion, double tolerance);

}  // namespace motiondb::core
