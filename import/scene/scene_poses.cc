#include "import/scene/scene_poses.h"

#include <cmath>

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

}  // namespace motiondb::importer
