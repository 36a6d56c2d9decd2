#include "core/view/state_axes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <atomic>

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

}  // namespace motiondb::core
