#include "core/view/node_summary.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "core/model/model.h"

namespace motiondb::core {

NodeSummaries::NodeSummaries(const Model& model, const StateAxes& axes)
    : model_(model), axes_(axes), frames_of_clip_(model.clips().size()) {
  std::map<std::string_view, int> numbers;
  for (const ModelClip& clip : model.clips()) {
    label_of_clip_.push_back(
        numbers.try_emplace(clip.label(), static_cast<int>(numbers.size())).first->second);
  }
}

NodeSummary NodeSummaries::Summarize(int layer, int node) {
  const Tree& tree = model_.tree();
  const Branch& branch = tree.branches()[tree.branch(layer, node)];
  const std::span frames(tree.frame_order().begin() + branch.begin,
                         tree.frame_order().begin() + branch.end);
  NodeSummary summary{.frame_count = static_cast<int>(frames.size())};
  std::vector<int> clips;
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (const std::int32_t frame : frames) {
    sum += axes_.projections.row(frame).cast<double>();
    const int clip = model_.clip_of_frame(frame);
    if (frames_of_clip_[clip]++ == 0) clips.push_back(clip);
  }
  const auto count = static_cast<double>(frames.size());
  const Eigen::RowVector3d mean = sum / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const std::int32_t frame : frames) {
    const Eigen::RowVector3d centred = axes_.projections.row(frame).cast<double>() - mean;
    covariance += centred.transpose() * centred / count;
  }
  summary.mean = mean.cast<float>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  for (int i = 0; i < 3; ++i) {
    Eigen::Vector3d axis = solver.eigenvectors().col(2 - i);
    FixSign(axis);
    summary.semi_axes.row(i) =
        (axis * std::sqrt(std::max(0.0, solver.eigenvalues()[2 - i]))).transpose().cast<float>();
  }

  std::ranges::sort(clips);
  summary.main_clip =
      *std::ranges::max_element(clips, {}, [&](int clip) { return frames_of_clip_[clip]; });
  std::int64_t same_label = 0;
  for (const int clip : clips) {
    const bool is_same = label_of_clip_[clip] == label_of_clip_[summary.main_clip];
    same_label += is_same ? frames_of_clip_[clip] : 0;
    frames_of_clip_[clip] = 0;
  }
  summary.label_fraction = static_cast<float>(static_cast<double>(same_label) / count);
  return summary;
}

MeanPose MeanPoseOf(const Model& model, int layer, int node) {
  double leg_lengths_m = 0;
  for (const ModelClip& clip : model.clips()) leg_lengths_m += clip.leg_length_m;
  const auto leg_length_m =
      static_cast<float>(leg_lengths_m / static_cast<double>(model.clips().size()));
  const Eigen::RowVectorXf state = model.gaussians()
                                       .means()
                                       .row(model.tree().branch(layer, node))
                                       .cwiseProduct(model.scale().divisor) *
                                   leg_length_m;
  const Eigen::Index markers = state.size() / 6;
  MeanPose pose{Eigen::RowVectorXf(3 * markers), Eigen::RowVectorXf(3 * markers)};
  for (Eigen::Index m = 0; m < markers; ++m) {
    pose.positions_m.segment<3>(3 * m) = state.segment<3>(6 * m);
    pose.velocities_m_s.segment<3>(3 * m) = state.segment<3>(6 * m + 3);
  }
  return pose;
}

}  // namespace motiondb::core
