// Where the virtual markers of a scheme are on a skeleton, and how they move with its degrees of
// freedom. Immutable after Create and safe to share between threads; each thread has a MarkerPose.
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
#include "core/motion/skeleton.h"

namespace motiondb::core {

struct BoundRule;

// Leg length (m) that the scheme's mapping gives the skeleton with all angles zero: hip to knee to
// ankle. INVALID_ARGUMENT if no mapping of the scheme fits the skeleton, or its size cannot be
// told.
absl::StatusOr<double> SkeletonLegLength(const MarkerScheme& scheme,
                                         const std::shared_ptr<const Skeleton>& skeleton);

// One pose and what follows from it; the caller's storage, made by MarkerKinematics::NewPose.
struct MarkerPose {
  Eigen::RowVectorXd angles;  // 1 x dof_count, rad and m
  std::vector<Eigen::Isometry3d> world_from_joint;
  Eigen::Matrix3Xd markers_m;  // 3 x marker_count, world
  // After Differentiate: the speed axis of each coordinate in the world, and the Jacobian's entries
  // that are not zero: for marker m, one column for each of Coordinates(m).
  std::vector<Eigen::Vector3d> axes;
  Eigen::Matrix3Xd jacobian;
};

// A pose changes along dof_count coordinates of velocity. They are the rates of the degrees of
// freedom, but for a joint with three unlimited rotations about axes at right angles: it turns
// freely, and its three are the angular velocity (rad/s) against its parent along the world's x, y
// and z. So a free root has no gimbal lock, and eq. 9 has the root's angular velocity.
class MarkerKinematics {
 public:
  // `leg_length_m` scales the mapping's offsets; without it, it is measured on the skeleton with
  // all angles zero. INVALID_ARGUMENT if no mapping of the scheme fits the skeleton.
  static absl::StatusOr<MarkerKinematics> Create(const MarkerScheme& scheme,
                                                 std::shared_ptr<const Skeleton> skeleton,
                                                 std::optional<double> leg_length_m = std::nullopt);

  const std::shared_ptr<const Skeleton>& skeleton() const { return skeleton_; }
  const std::vector<std::string>& marker_names() const { return marker_names_; }
  int marker_count() const { return static_cast<int>(marker_names_.size()); }
  int dof_count() const { return skeleton_->dof_count(); }

  // The coordinates that move a marker, ascending, and where their columns begin in a Jacobian.
  std::span<const int> Coordinates(int marker) const;
  int first_column(int marker) const { return first_column_[marker]; }
  bool TurnsFreely(int joint) const { return turns_freely_[joint]; }
  bool IsRotation(int coordinate) const { return is_rotation_[coordinate]; }

  // Storage for one pose, with all angles zero and not yet placed.
  MarkerPose NewPose() const;
  // Joints and markers from pose.angles. Takes no memory.
  void Place(MarkerPose& pose) const;
  // Axes and Jacobian of a placed pose. Takes no memory.
  void Differentiate(MarkerPose& pose) const;
  // to.angles = from.angles moved by `step` (1 x dof_count; a coordinate of velocity for one unit
  // of time), not kept within limits. Takes no memory. `from` must be placed.
  void Advance(const MarkerPose& from, const Eigen::Ref<const Eigen::VectorXd>& step,
               MarkerPose& to) const;
  // Rewrites the pose's angles as those nearest to `angles` (1 x dof_count) that mean the same
  // pose: without whole turns between them, and of the two ways to write a free rotation the
  // nearer. Takes no memory. `pose` must be placed.
  void RunOn(const Eigen::RowVectorXd& angles, MarkerPose& pose) const;

 private:
  // One summand of a marker: a weighted joint origin, or an offset in a joint's frame (m).
  struct Term {
    int marker;
    int joint;
    double weight;
    Eigen::Vector3d offset_m;
    bool is_offset;
  };
  // What one coordinate does to one term: it adds to this column of the Jacobian.
  struct Influence {
    int term;
    int coordinate;
    int column;
  };

  MarkerKinematics() = default;
  void AddTerms(const BoundRule& rule, double leg_length_m, int marker);
  void AddInfluences();
  // The angles of a joint that turns freely which give it this rotation in the world; of all such,
  // those nearest to `previous`.
  Eigen::Vector3d FreeAngles(int joint, const Eigen::Matrix3d& world_from_joint,
                             const MarkerPose& pose, const Eigen::Vector3d& previous) const;
  // Calls visit(coordinate) for all that move the term.
  template <typename Visit>
  void ForEachCoordinate(const Term& term, Visit visit) const;

  std::shared_ptr<const Skeleton> skeleton_;
  std::vector<std::string> marker_names_;
  std::vector<bool> turns_freely_;  // of each joint
  std::vector<int> joint_of_;       // of each coordinate
  std::vector<bool> is_rotation_;   // of each coordinate
  std::vector<Term> terms_;         // by marker
  std::vector<int> coordinates_;    // of all markers, one after the other
  std::vector<int> first_column_;   // of each marker into coordinates_; one more at the end
  std::vector<Influence> influences_;
};

// The limits of a skeleton's degrees of freedom. Plain values; safe to call from any thread.

// 1 x dof_count each, rad and m; infinite where there is no limit.
struct JointLimits {
  Eigen::RowVectorXd lower;
  Eigen::RowVectorXd upper;
};

JointLimits LimitsOf(const Skeleton& skeleton);
// Limits that nothing oversteps.
JointLimits NoLimits(const Skeleton& skeleton);

// The number of angles (one a frame and degree of freedom) that are beyond the skeleton's own
// limits by more than `tolerance` (rad or m), or not finite.
int CountLimitViolations(const JointMotion& motion, double tolerance);

}  // namespace motiondb::core
