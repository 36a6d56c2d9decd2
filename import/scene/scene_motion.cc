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
#include "import/scene/scene_poses.h"

namespace motiondb::importer {

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
