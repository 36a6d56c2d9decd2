#include "core/view/model_picture.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "core/model/model.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

constexpr int kParts = 4;  // of the sums, for any number of threads
constexpr Eigen::Index kBlockFrames = 512;

using States = Eigen::Ref<const FrameMatrix>;

// Calls body(part, first, count) for blocks of consecutive frames; each part is one thread's.
// Returns whether all were called.
template <typename Body>
bool ForEachBlock(const States& states, const ParallelFor& parallel, const Cancelled& cancelled,
                  const Body& body) {
  std::atomic<bool> is_cancelled = false;
  parallel(kParts, [&](int part) {
    const Eigen::Index end = (part + 1) * states.rows() / kParts;
    for (Eigen::Index first = part * states.rows() / kParts; first < end; first += kBlockFrames) {
      if (is_cancelled || (cancelled && cancelled())) {
        is_cancelled = true;
        return;
      }
      body(part, first, std::min(kBlockFrames, end - first));
    }
  });
  return !is_cancelled;
}

const float* Row(const States& states, Eigen::Index frame) {
  return states.data() + frame * states.outerStride();
}

}  // namespace

absl::StatusOr<StateAxes> FindStateAxes(const States& states, const ParallelFor& parallel,
                                        const Cancelled& cancelled) {
  const absl::Status stopped = absl::CancelledError("finding the principal axes was cancelled");
  const Eigen::Index dimensions = states.cols();
  const auto frames = static_cast<double>(std::max<Eigen::Index>(1, states.rows()));
  std::array<Eigen::VectorXd, kParts> sums;
  sums.fill(Eigen::VectorXd::Zero(dimensions));
  if (!ForEachBlock(states, parallel, cancelled,
                    [&](int part, Eigen::Index first, Eigen::Index count) {
                      AddRows(Row(states, first), static_cast<int>(count),
                              static_cast<int>(dimensions), sums[part].data());
                    })) {
    return stopped;
  }
  StateAxes found;
  found.mean = Eigen::VectorXd::Zero(dimensions);
  for (const Eigen::VectorXd& sum : sums) found.mean += sum / frames;

  std::array<Eigen::MatrixXd, kParts> scatters;
  scatters.fill(Eigen::MatrixXd::Zero(dimensions, dimensions));
  const Eigen::RowVectorXf centre = found.mean.transpose().cast<float>();
  if (!ForEachBlock(
          states, parallel, cancelled, [&](int part, Eigen::Index first, Eigen::Index count) {
            const FrameMatrix centred = states.middleRows(first, count).rowwise() - centre;
            Eigen::MatrixXf scatter = Eigen::MatrixXf::Zero(dimensions, dimensions);
            scatter.selfadjointView<Eigen::Lower>().rankUpdate(centred.transpose());
            scatters[part].triangularView<Eigen::Lower>() += scatter.cast<double>();
          })) {
    return stopped;
  }
  for (int part = 1; part < kParts; ++part) scatters[0] += scatters[part];
  // The solver reads the lower triangle. Eigenvalues ascend.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scatters[0] / frames);
  const Eigen::Index kept = std::min<Eigen::Index>(kReportedAxes, dimensions);
  found.axes = solver.eigenvectors().rightCols(kept).rowwise().reverse();
  const Eigen::VectorXd variances = solver.eigenvalues().cwiseMax(0);
  const double total = variances.sum();
  found.variance_fractions = Eigen::VectorXd::Zero(kept);
  if (total > 0) found.variance_fractions = variances.tail(kept).reverse() / total;
  for (Eigen::Index axis = 0; axis < kept; ++axis) FixSign(found.axes.col(axis));

  const Eigen::Index drawn = std::min<Eigen::Index>(kDrawnAxes, kept);
  FrameMatrix basis = FrameMatrix::Zero(dimensions, kDrawnAxes);
  basis.leftCols(drawn) = found.axes.leftCols(drawn).cast<float>();
  const Eigen::RowVectorXf origin = (found.mean.transpose() * basis.cast<double>()).cast<float>();
  found.projections.resize(states.rows(), kDrawnAxes);
  if (!ForEachBlock(states, parallel, cancelled, [&](int, Eigen::Index first, Eigen::Index count) {
        MultiplyRows(Row(states, first), static_cast<int>(count), static_cast<int>(dimensions),
                     basis.data(), kDrawnAxes, found.projections.row(first).data());
        found.projections.middleRows(first, count).rowwise() -= origin;
      })) {
    return stopped;
  }
  return found;
}

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
