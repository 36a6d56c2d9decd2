#include "core/kinematics/marker_kinematics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"
#include "core/motion/marker_set.h"
#include "core/motion/states.h"

namespace motiondb::core {

namespace {

constexpr double kRightAngle = 1e-9;  // cosine below which axes are perpendicular

// Index of the first rotation among the joint's degrees of freedom.
int FirstRotation(const Joint& joint) {
  const auto at = std::find_if(joint.dofs.begin(), joint.dofs.end(),
                               [](const Dof& dof) { return dof.kind == Dof::Kind::kRotation; });
  return static_cast<int>(at - joint.dofs.begin());
}

std::array<Eigen::Vector3d, 3> RotationAxes(const Joint& joint) {
  const int first = FirstRotation(joint);
  return {joint.dofs[first].axis, joint.dofs[first + 1].axis, joint.dofs[first + 2].axis};
}

bool HasFreeRotation(const Joint& joint) {
  const int first = FirstRotation(joint);
  if (static_cast<int>(joint.dofs.size()) - first != 3) return false;
  const auto axes = RotationAxes(joint);
  return std::all_of(
             joint.dofs.begin() + first, joint.dofs.end(),
             [](const Dof& dof) { return std::isinf(dof.lower) && std::isinf(dof.upper); }) &&
         std::abs(axes[0].dot(axes[1])) < kRightAngle &&
         std::abs(axes[1].dot(axes[2])) < kRightAngle &&
         std::abs(axes[2].dot(axes[0])) < kRightAngle;
}

}  // namespace

template <typename Visit>
void MarkerKinematics::ForEachCoordinate(const Term& term, Visit visit) const {
  for (int j = term.joint; j >= 0; j = skeleton_->joints()[j].parent) {
    const Joint& joint = skeleton_->joints()[j];
    for (std::size_t k = 0; k < joint.dofs.size(); ++k) {
      // A joint's rotation moves offsets in its frame but not its own origin; a translation moves
      // origins but not offset directions.
      const bool rotation = joint.dofs[k].kind == Dof::Kind::kRotation;
      if (rotation ? term.is_offset || j != term.joint : !term.is_offset) {
        visit(skeleton_->first_dof(j) + static_cast<int>(k));
      }
    }
  }
}

absl::StatusOr<MarkerKinematics> MarkerKinematics::Create(const MarkerScheme& scheme,
                                                          std::shared_ptr<const Skeleton> skeleton,
                                                          std::optional<double> leg_length_m) {
  MOTIONDB_ASSIGN_OR_RETURN(const BoundMapping mapping, BindMapping(scheme, JointNames(*skeleton)));
  if (mapping.has_offsets && !leg_length_m) {
    MOTIONDB_ASSIGN_OR_RETURN(leg_length_m, SkeletonLegLength(scheme, skeleton));
  }
  MarkerKinematics made;
  made.skeleton_ = std::move(skeleton);
  made.marker_names_ = scheme.set.markers;
  for (int j = 0; j < made.skeleton_->joint_count(); ++j) {
    const Joint& joint = made.skeleton_->joints()[j];
    made.turns_freely_.push_back(HasFreeRotation(joint));
    for (const Dof& dof : joint.dofs) {
      made.joint_of_.push_back(j);
      made.is_rotation_.push_back(dof.kind == Dof::Kind::kRotation);
    }
  }
  for (int m = 0; m < made.marker_count(); ++m) {
    made.AddTerms(mapping.rules[m], leg_length_m.value_or(0), m);
  }
  made.AddInfluences();
  return made;
}

void MarkerKinematics::AddTerms(const BoundRule& rule, double leg_length_m, int marker) {
  for (const auto& [joint, weight] : rule.points) {
    terms_.push_back({marker, joint, weight, Eigen::Vector3d::Zero(), false});
  }
  if (rule.offset_joint >= 0) {
    terms_.push_back({marker, rule.offset_joint, 1, leg_length_m * rule.offset, true});
  }
}

void MarkerKinematics::AddInfluences() {
  std::vector<std::set<int>> moved_by(marker_names_.size());
  for (const Term& term : terms_) {
    ForEachCoordinate(term, [&](int c) { moved_by[term.marker].insert(c); });
  }
  for (const std::set<int>& moving : moved_by) {
    first_column_.push_back(static_cast<int>(coordinates_.size()));
    coordinates_.insert(coordinates_.end(), moving.begin(), moving.end());
  }
  first_column_.push_back(static_cast<int>(coordinates_.size()));
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const auto own = Coordinates(terms_[t].marker);
    ForEachCoordinate(terms_[t], [&](int c) {
      const auto at = std::lower_bound(own.begin(), own.end(), c) - own.begin();
      influences_.push_back(
          {static_cast<int>(t), c, first_column_[terms_[t].marker] + static_cast<int>(at)});
    });
  }
}

std::span<const int> MarkerKinematics::Coordinates(int marker) const {
  return std::span(coordinates_)
      .subspan(first_column_[marker], first_column_[marker + 1] - first_column_[marker]);
}

MarkerPose MarkerKinematics::NewPose() const {
  return {.angles = Eigen::RowVectorXd::Zero(dof_count()),
          .world_from_joint = std::vector<Eigen::Isometry3d>(skeleton_->joint_count()),
          .markers_m = Eigen::Matrix3Xd::Zero(3, marker_count()),
          .axes = std::vector<Eigen::Vector3d>(dof_count()),
          .jacobian = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(coordinates_.size()))};
}

void MarkerKinematics::Place(MarkerPose& pose) const {
  ForwardKinematics(*skeleton_, pose.angles, pose.world_from_joint);
  pose.markers_m.setZero();
  for (const Term& term : terms_) {
    const Eigen::Isometry3d& world_from_joint = pose.world_from_joint[term.joint];
    if (term.is_offset) {
      pose.markers_m.col(term.marker) += world_from_joint.linear() * term.offset_m;
    } else {
      pose.markers_m.col(term.marker) += term.weight * world_from_joint.translation();
    }
  }
}

void MarkerKinematics::Differentiate(MarkerPose& pose) const {
  WorldDofAxes(*skeleton_, pose.angles, pose.world_from_joint, pose.axes);
  for (int j = 0; j < skeleton_->joint_count(); ++j) {
    if (!turns_freely_[j]) continue;
    const int first = skeleton_->first_dof(j) + FirstRotation(skeleton_->joints()[j]);
    for (int i = 0; i < 3; ++i) pose.axes[first + i] = Eigen::Vector3d::Unit(i);
  }
  pose.jacobian.setZero();
  for (const Influence& influence : influences_) {
    const Term& term = terms_[influence.term];
    const Eigen::Isometry3d& world_from_joint = pose.world_from_joint[term.joint];
    const Eigen::Vector3d& axis = pose.axes[influence.coordinate];
    if (term.is_offset) {
      const Eigen::Vector3d arm = world_from_joint.linear() * term.offset_m;
      pose.jacobian.col(influence.column) += axis.cross(arm);
    } else if (is_rotation_[influence.coordinate]) {
      const Eigen::Vector3d arm =
          world_from_joint.translation() -
          pose.world_from_joint[joint_of_[influence.coordinate]].translation();
      pose.jacobian.col(influence.column) += term.weight * axis.cross(arm);
    } else {
      pose.jacobian.col(influence.column) += term.weight * axis;
    }
  }
}

void MarkerKinematics::Advance(const MarkerPose& from,
                               const Eigen::Ref<const Eigen::VectorXd>& step,
                               MarkerPose& to) const {
  to.angles = from.angles + step.transpose();
  for (int j = 0; j < skeleton_->joint_count(); ++j) {
    if (!turns_freely_[j]) continue;
    const Joint& joint = skeleton_->joints()[j];
    const int first = skeleton_->first_dof(j) + FirstRotation(joint);
    const Eigen::Vector3d turn = step.segment<3>(first);
    const double angle = turn.norm();
    if (angle == 0) continue;
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() *
                                   from.world_from_joint[j].linear();
    const Eigen::Vector3d before = from.angles.segment<3>(first).transpose();
    to.angles.segment<3>(first) = FreeAngles(j, turned, from, before).transpose();
  }
}

Eigen::Vector3d MarkerKinematics::FreeAngles(int j, const Eigen::Matrix3d& world_from_joint,
                                             const MarkerPose& pose,
                                             const Eigen::Vector3d& previous) const {
  const Joint& joint = skeleton_->joints()[j];
  Eigen::Matrix3d parent_from_joint = world_from_joint;
  if (joint.parent >= 0) {
    parent_from_joint = pose.world_from_joint[joint.parent].linear().transpose() * world_from_joint;
  }
  const Eigen::Matrix3d own =
      joint.pre_rotation.transpose() * parent_from_joint * joint.post_rotation.transpose();
  return AnglesAboutAxes(own, RotationAxes(joint), previous);
}

void MarkerKinematics::UnwrapAngles(const Eigen::RowVectorXd& angles, MarkerPose& pose) const {
  for (int j = 0; j < skeleton_->joint_count(); ++j) {
    const Joint& joint = skeleton_->joints()[j];
    const int first_rotation = FirstRotation(joint);
    const int first = skeleton_->first_dof(j) + first_rotation;
    if (turns_freely_[j]) {
      const Eigen::Vector3d before = angles.segment<3>(first).transpose();
      pose.angles.segment<3>(first) =
          FreeAngles(j, pose.world_from_joint[j].linear(), pose, before).transpose();
      continue;
    }
    for (int c = first; c < skeleton_->first_dof(j) + static_cast<int>(joint.dofs.size()); ++c) {
      const Dof& dof = joint.dofs[c - skeleton_->first_dof(j)];
      const double nearest =
          angles[c] + std::remainder(pose.angles[c] - angles[c], 2 * std::numbers::pi);
      if (nearest >= dof.lower && nearest <= dof.upper) pose.angles[c] = nearest;
    }
  }
}

JointLimits LimitsOf(const Skeleton& skeleton) {
  JointLimits limits = NoLimits(skeleton);
  Eigen::Index column = 0;
  for (const Joint& joint : skeleton.joints()) {
    for (const Dof& dof : joint.dofs) {
      limits.lower[column] = dof.lower;
      limits.upper[column++] = dof.upper;
    }
  }
  return limits;
}

JointLimits NoLimits(const Skeleton& skeleton) {
  const auto infinite =
      Eigen::RowVectorXd::Constant(skeleton.dof_count(), std::numeric_limits<double>::infinity());
  return {-infinite, infinite};
}

int CountLimitViolations(const JointMotion& motion, double tolerance) {
  const JointLimits limits = LimitsOf(*motion.skeleton);
  Eigen::Index count = 0;
  for (Eigen::Index frame = 0; frame < motion.angles.rows(); ++frame) {
    const auto angles = motion.angles.row(frame).array();
    const auto within = angles >= limits.lower.array() - tolerance &&
                        angles <= limits.upper.array() + tolerance && angles.isFinite();
    count += angles.size() - within.count();
  }
  return static_cast<int>(count);
}

}  // namespace motiondb::core
