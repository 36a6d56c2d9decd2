#include "core/recognition/metric_observation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace motiondb::core {

absl::StatusOr<MetricObservation> MetricObservation::Create(const Model& model, FrameMatrix scaled,
                                                            const Cancelled& cancelled) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index d = 0; d < scaled.cols(); ++d) {
    if (!scaled.col(d).array().isNaN().all()) seen.push_back(d);
  }
  std::shared_ptr<const MotionMetric> own;
  if (!seen.empty() && std::ssize(seen) < scaled.cols()) {
    own = std::make_shared<const MotionMetric>(MetricOfSeen(model.metric(), seen));
  }
  for (Eigen::Index t = 0; t < scaled.rows(); ++t) {
    if (!scaled.row(t).hasNaN()) continue;
    if (cancelled && cancelled()) return absl::CancelledError("the query was cancelled");
    FillUnseen(model.metric(), scaled.row(t));
  }
  FrameMatrix projected = Project(own == nullptr ? model.metric() : *own, scaled);
  return MetricObservation{std::move(scaled), std::move(projected), std::move(own)};
}

std::vector<int> ComparedFrames(int first, int width, int stride, bool from_start) {
  const int newest = first + width - 1;
  std::vector<int> frames;
  for (int f = from_start ? first : first + (width - 1) % stride; f + stride <= newest;
       f += stride) {
    frames.push_back(f);
  }
  frames.push_back(newest);
  return frames;
}

MotionMetric MetricOfSeen(const MotionMetric& metric, const std::vector<Eigen::Index>& seen) {
  const Eigen::Index dimensions = metric.mean.size();
  std::vector<Eigen::Index> unseen;
  for (Eigen::Index d = 0; d < dimensions; ++d) {
    if (!std::binary_search(seen.begin(), seen.end(), d)) unseen.push_back(d);
  }
  // The inverse of a block of S follows from the inverse of S, which the whitening contains.
  const Eigen::MatrixXd inverse = (metric.whitening * metric.whitening.transpose()).cast<double>();
  Eigen::MatrixXd of_seen = inverse(seen, seen);
  if (!unseen.empty()) {
    const Eigen::MatrixXd between = inverse(unseen, seen);
    of_seen -=
        between.transpose() * Eigen::LLT<Eigen::MatrixXd>(inverse(unseen, unseen)).solve(between);
  }
  const Eigen::MatrixXd whitening = Eigen::LLT<Eigen::MatrixXd>(of_seen).matrixL();
  const Eigen::MatrixXd whitened =
      whitening.transpose() * metric.loadings(seen, Eigen::all).cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spread(whitened.transpose() * whitened);
  // Directions without variance in the stored motion are excluded.
  const Eigen::Index directions =
      std::max<Eigen::Index>(1, (spread.eigenvalues().array() > 1e-9).count());
  const Eigen::MatrixXd projection =
      whitening * whitened * spread.eigenvectors().rightCols(directions) *
      spread.eigenvalues().tail(directions).cwiseSqrt().cwiseInverse().asDiagonal();

  MotionMetric own{metric.mean, metric.loadings, metric.noise};
  own.whitening.setZero(dimensions, whitening.cols());
  own.projection.setZero(dimensions, directions);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    own.whitening.row(seen[i]) = whitening.row(static_cast<Eigen::Index>(i)).cast<float>();
    own.projection.row(seen[i]) = projection.row(static_cast<Eigen::Index>(i)).cast<float>();
  }
  return own;
}

void FillUnseen(const MotionMetric& metric, Eigen::Ref<Eigen::RowVectorXf> state) {
  std::vector<Eigen::Index> seen;
  std::vector<Eigen::Index> unseen;
  for (Eigen::Index d = 0; d < state.size(); ++d) {
    (std::isnan(state[d]) ? unseen : seen).push_back(d);
  }
  if (unseen.empty()) return;
  const Eigen::MatrixXd loadings = metric.loadings(seen, Eigen::all).cast<double>();
  const Eigen::VectorXd difference = (state(seen) - metric.mean(seen)).transpose().cast<double>();
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(loadings.cols(), loadings.cols());
  if (!seen.empty()) precision.selfadjointView<Eigen::Lower>().rankUpdate(loadings.transpose());
  precision.diagonal().array() += metric.noise;
  const Eigen::VectorXd hidden = precision.selfadjointView<Eigen::Lower>().llt().solve(
      Eigen::VectorXd(loadings.transpose() * difference));
  for (const Eigen::Index d : unseen) {
    state[d] = metric.mean[d] + static_cast<float>(metric.loadings.row(d).cast<double>() * hidden);
  }
}

double NoiseEnergy(const Eigen::Ref<const FrameMatrix>& window) {
  const Eigen::Index frames = window.rows();
  if (frames < 4) return 0;
  FrameMatrix differences = window.bottomRows(frames - 1) - window.topRows(frames - 1);
  const auto differentiate = [&differences] {
    const Eigen::Index rows = differences.rows() - 1;
    differences = (differences.bottomRows(rows) - differences.topRows(rows)).eval();
    return static_cast<double>(differences.squaredNorm()) / static_cast<double>(rows);
  };
  const double second = differentiate();
  const double third = differentiate();
  return std::max(0.0, 3.0 / 8 * second - 1.0 / 16 * third);
}

}  // namespace motiondb::core
