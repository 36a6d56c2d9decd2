#include "tests/core/tree/exact_split.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/tree/split_node.h"

namespace motiondb::tests {
namespace {

core::FrameMatrix Rows(const core::FrameMatrix& states, const std::vector<std::int32_t>& frames) {
  core::FrameMatrix rows(frames.size(), states.cols());
  for (std::size_t i = 0; i < frames.size(); ++i) rows.row(i) = states.row(frames[i]);
  return rows;
}

// Returns the frames left and right of the threshold, each ascending; empty if there is no split.
std::pair<std::vector<std::int32_t>, std::vector<std::int32_t>> Split(
    const core::FrameMatrix& states, const std::vector<std::int32_t>& frames, int min_frames) {
  const core::FrameMatrix rows = Rows(states, frames);
  const ExactAxes exact = FindExactAxes(rows);
  Eigen::VectorXd axis = exact.axes.rightCols<1>();
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  std::vector<std::pair<double, std::int32_t>> projected;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    projected.emplace_back((rows.row(i).cast<double>() - exact.mean).dot(axis), frames[i]);
  }
  std::sort(projected.begin(), projected.end());
  std::vector<double> values;
  for (const auto& [value, frame] : projected) values.push_back(value);
  const int left = core::MinimumErrorThreshold(values);
  if (left < min_frames || static_cast<int>(frames.size()) - left < min_frames) return {};
  std::pair<std::vector<std::int32_t>, std::vector<std::int32_t>> sides;
  for (std::size_t i = 0; i < projected.size(); ++i) {
    (static_cast<int>(i) < left ? sides.first : sides.second).push_back(projected[i].second);
  }
  std::sort(sides.first.begin(), sides.first.end());
  std::sort(sides.second.begin(), sides.second.end());
  return sides;
}

}  // namespace

ExactAxes FindExactAxes(const core::FrameMatrix& states) {
  ExactAxes exact;
  exact.mean = states.cast<double>().colwise().mean();
  const Eigen::MatrixXd centred = states.cast<double>().rowwise() - exact.mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centred.transpose() * centred);
  exact.scatters = solver.eigenvalues();
  exact.axes = solver.eigenvectors();
  return exact;
}

std::vector<double> SortedProjections(const core::FrameMatrix& states,
                                      const Eigen::RowVectorXd& mean, const Eigen::VectorXd& axis) {
  std::vector<double> values;
  for (Eigen::Index f = 0; f < states.rows(); ++f) {
    values.push_back((states.row(f).cast<double>() - mean).dot(axis));
  }
  std::sort(values.begin(), values.end());
  return values;
}

double MinCutCost(const std::vector<double>& sorted) {
  const int cut = core::MinimumErrorThreshold(sorted);
  if (cut == 0) return 0;
  const auto cost = [](std::span<const double> side) {
    const auto n = static_cast<double>(side.size());
    const double mean = std::accumulate(side.begin(), side.end(), 0.0) / n;
    double squares = 0;
    for (double v : side) squares += (v - mean) * (v - mean);
    return n * std::log(squares / n / n);
  };
  return cost(std::span(sorted).first(cut)) + cost(std::span(sorted).subspan(cut));
}

std::vector<std::vector<std::int32_t>> ExactNodes(const core::FrameMatrix& states, int min_frames) {
  std::vector<std::vector<std::int32_t>> nodes(1);
  nodes[0].resize(static_cast<std::size_t>(states.rows()));
  std::iota(nodes[0].begin(), nodes[0].end(), 0);
  for (std::size_t n = 0; n < nodes.size(); ++n) {  // children are appended: layer by layer
    if (static_cast<int>(nodes[n].size()) < 2 * min_frames) continue;
    auto [left, right] = Split(states, nodes[n], min_frames);
    if (left.empty()) continue;
    nodes.push_back(std::move(left));
    nodes.push_back(std::move(right));
  }
  return nodes;
}

}  // namespace motiondb::tests
