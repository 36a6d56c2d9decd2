#include "import/scene/scene_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"
#include "core/motion/forward_kinematics.h"

namespace motiondb::importer {
namespace {

// Returns the rotation nearest to a matrix without shear: its columns, normalized.
bool NormalizeColumns(const Eigen::Matrix3d& matrix, Eigen::Matrix3d& rotation) {
  constexpr double kOrthogonal = 1e-7;
  rotation = matrix.colwise().normalized();
  return std::abs(rotation.col(0).dot(rotation.col(1))) < kOrthogonal &&
         std::abs(rotation.col(1).dot(rotation.col(2))) < kOrthogonal &&
         std::abs(rotation.col(2).dot(rotation.col(0))) < kOrthogonal;
}

// Newton's iteration for the polar decomposition: the mean of the matrix and its inverse transpose.
Eigen::Matrix3d PolarRotation(const Eigen::Matrix3d& matrix) {
  constexpr int kMaxSteps = 50;
  constexpr double kConverged = 1e-14;
  Eigen::Matrix3d rotation = matrix;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Matrix3d next = 0.5 * (rotation + rotation.inverse().transpose());
    const double change = (next - rotation).cwiseAbs().maxCoeff();
    rotation = next;
    if (change < kConverged) break;
  }
  Eigen::Matrix3d exact;
  NormalizeColumns(rotation, exact);
  return exact;
}

Eigen::Matrix3d OrthonormalPart(const Eigen::Matrix3d& linear, const Eigen::Matrix3d& otherwise) {
  constexpr double kFlat = 1e-9;  // of the product of the columns' lengths
  const double largest = linear.cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return otherwise;
  Eigen::Matrix3d matrix = linear / largest;
  const double volume = matrix.determinant();
  if (!(std::abs(volume) > kFlat * matrix.colwise().norm().prod())) return otherwise;
  if (volume < 0) matrix = -matrix;
  Eigen::Matrix3d rotation;
  return NormalizeColumns(matrix, rotation) ? rotation : PolarRotation(matrix);
}

}  // namespace

ScenePoses::ScenePoses(const SceneSkeleton& skeleton, const std::vector<JointTrack>& tracks)
    : skeleton_(skeleton),
      tracks_(tracks),
      cursors_(tracks.begin(), tracks.end()),
      in_scene_(tracks.size()),
      rotations_(tracks.size()),
      local_(tracks.size()) {}

template <typename LocalOf>
void ScenePoses::EvaluateWith(const LocalOf& local_of) {
  for (std::size_t j = 0; j < tracks_.size(); ++j) {
    const int parent = skeleton_.joints[j].parent;
    const Eigen::Affine3d& above =
        parent < 0 ? skeleton_.scene_from_root_parent : in_scene_[parent];
    in_scene_[j] = above * local_of(j);
    Eigen::Isometry3d& local = local_[j];
    local.makeAffine();
    if (parent < 0) {
      rotations_[j] = OrthonormalPart(in_scene_[j].linear(), Eigen::Matrix3d::Identity());
      local.linear() = rotations_[j];
      local.translation() = in_scene_[j].translation();
    } else {
      rotations_[j] = OrthonormalPart(in_scene_[j].linear(), rotations_[parent]);
      local.linear() = rotations_[parent].transpose() * rotations_[j];
      local.translation() = rotations_[parent].transpose() *
                            (in_scene_[j].translation() - in_scene_[parent].translation());
    }
  }
}

void ScenePoses::EvaluateRest() {
  EvaluateWith([this](std::size_t j) { return tracks_[j].rest; });
}

void ScenePoses::Evaluate(double ticks) {
  EvaluateWith([&](std::size_t j) { return cursors_[j].LocalAt(ticks); });
}

int ScenePoses::FindOverflow() const {
  constexpr double kMaxCoordinate = 1e15;
  for (std::size_t j = 0; j < in_scene_.size(); ++j) {
    if (!(position(j).cwiseAbs().maxCoeff() < kMaxCoordinate)) return static_cast<int>(j);
  }
  return -1;
}

namespace {

using AxisOrder = std::array<Eigen::Vector3d, 3>;

AxisOrder OrderOf(bool is_zyx) {
  const auto axis = [](int i) -> Eigen::Vector3d { return Eigen::Vector3d::Unit(i); };
  return is_zyx ? AxisOrder{axis(2), axis(1), axis(0)} : AxisOrder{axis(2), axis(0), axis(1)};
}

bool HasChannel(const JointTrack& track) {
  return std::any_of(track.parts.begin(), track.parts.end(),
                     [](const TrackPart& part) { return part.channel != nullptr; });
}

}  // namespace

TakeSampler::TakeSampler(const SampledTake& take)
    : take_(take), uses_(take.skeleton.joints.size()) {}

double TakeSampler::TicksOf(int frame) const {
  return take_.timing.first_tick + frame * take_.timing.ticks_per_frame;
}

void TakeSampler::Add(const Eigen::Isometry3d& local, JointUse& use) const {
  constexpr double kSameRotation = 1e-6;
  use.slide = std::max(use.slide, (local.translation() - use.first.translation()).norm());
  use.rotates = use.rotates || (local.linear() - use.first.linear()).norm() > kSameRotation;
  const Eigen::Matrix3d turn = use.rest.linear().transpose() * local.linear();
  use.lock_zxy = std::max(use.lock_zxy, std::abs(turn(2, 1)));
  use.lock_zyx = std::max(use.lock_zyx, std::abs(turn(2, 0)));
}

absl::Status TakeSampler::Measure() {
  ScenePoses poses(take_.skeleton, take_.tracks);
  poses.EvaluateRest();
  for (std::size_t j = 0; j < uses_.size(); ++j) {
    uses_[j].rest = poses.local(j);
    uses_[j].rotates = HasChannel(take_.tracks[j]);
  }
  for (int frame = 0; frame < take_.timing.frames; ++frame) {
    poses.Evaluate(TicksOf(frame));
    if (const int joint = poses.FindOverflow(); joint >= 0) {
      return core::InvalidArgument("{}: frame {}: the position of node '{}' is not finite",
                                   take_.file_name, frame,
                                   core::Shown(take_.skeleton.joints[joint].name));
    }
    if (frame == 0) {
      Eigen::AlignedBox3d box;
      for (std::size_t j = 0; j < uses_.size(); ++j) {
        uses_[j].first = poses.local(j);
        box.extend(poses.position(j));
      }
      size_ = box.diagonal().norm();
    }
    for (std::size_t j = 0; j < uses_.size(); ++j) Add(poses.local(j), uses_[j]);
  }
  return absl::OkStatus();
}

core::FrameMatrix TakeSampler::SamplePositions() const {
  constexpr int kSamples = 32;
  const int count = std::min(kSamples, take_.timing.frames);
  core::FrameMatrix positions(count, 3 * std::ssize(uses_));
  ScenePoses poses(take_.skeleton, take_.tracks);
  for (int i = 0; i < count; ++i) {
    poses.Evaluate(TicksOf(static_cast<int>(std::int64_t{i} * take_.timing.frames / count)));
    for (std::size_t j = 0; j < uses_.size(); ++j) {
      positions.block<1, 3>(i, 3 * static_cast<Eigen::Index>(j)) =
          (poses.position(j) - uses_[0].first.translation()).cast<float>().transpose();
    }
  }
  return positions;
}

core::Joint TakeSampler::MakeJoint(std::size_t j, const Eigen::Matrix3d& world_from_scene,
                                   double metres_per_unit) const {
  const JointUse& use = uses_[j];
  const SceneJoint& named = take_.skeleton.joints[j];
  const Eigen::Matrix3d axes = named.parent < 0 ? world_from_scene : Eigen::Matrix3d::Identity();
  const Eigen::Isometry3d& pose = use.rotates ? use.rest : use.first;
  core::Joint joint{.name = named.name,
                    .parent = named.parent,
                    .offset_m = axes * use.first.translation() * metres_per_unit,
                    .pre_rotation = axes * pose.linear()};
  if (Slides(use)) {
    for (int axis = 0; axis < 3; ++axis) {
      joint.dofs.push_back(
          {.kind = core::Dof::Kind::kTranslation, .axis = axes * Eigen::Vector3d::Unit(axis)});
    }
  }
  if (use.rotates) {
    for (const Eigen::Vector3d& axis : OrderOf(use.lock_zyx < use.lock_zxy)) {
      joint.dofs.push_back({.kind = core::Dof::Kind::kRotation, .axis = axis});
    }
  }
  return joint;
}

absl::StatusOr<core::JointMotion> TakeSampler::Motion(const core::SourceReport& report,
                                                      double metres_per_scene_unit) const {
  const Eigen::Matrix3d world_from_scene = core::WorldFromFile(report.up_axis);
  std::vector<core::Joint> joints;
  for (std::size_t j = 0; j < uses_.size(); ++j) {
    joints.push_back(MakeJoint(j, world_from_scene, metres_per_scene_unit));
  }
  const std::string name = joints.front().name;
  MOTIONDB_ASSIGN_OR_RETURN(core::Skeleton skeleton,
                            core::Skeleton::Create(name, std::move(joints)));
  core::JointMatrix angles(take_.timing.frames, skeleton.dof_count());
  std::vector<Eigen::Vector3d> previous(uses_.size(), Eigen::Vector3d::Zero());
  ScenePoses poses(take_.skeleton, take_.tracks);
  for (int frame = 0; frame < take_.timing.frames; ++frame) {
    poses.Evaluate(TicksOf(frame));
    for (std::size_t j = 0; j < uses_.size(); ++j) {
      const JointUse& use = uses_[j];
      Eigen::Index column = skeleton.first_dof(static_cast<int>(j));
      if (Slides(use)) {
        angles.block<1, 3>(frame, column) =
            metres_per_scene_unit *
            (poses.local(j).translation() - use.first.translation()).transpose();
        column += 3;
      }
      if (!use.rotates) continue;
      previous[j] = core::AnglesAboutAxes(use.rest.linear().transpose() * poses.local(j).linear(),
                                          OrderOf(use.lock_zyx < use.lock_zxy), previous[j]);
      angles.block<1, 3>(frame, column) = previous[j].transpose();
    }
  }
  return core::JointMotion{.skeleton = std::make_shared<const core::Skeleton>(std::move(skeleton)),
                           .frame_rate_hz = take_.timing.rate_hz,
                           .angles = std::move(angles)};
}

}  // namespace motiondb::importer
