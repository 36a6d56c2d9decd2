#include "core/model/motion_metric.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "core/model/label_units.h"
#include "core/model/metric_frames.h"
#include "core/model/model.h"
#include "core/motion/samples.h"
#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

constexpr int kParts = 16;           // partial sums, for any number of threads
constexpr Eigen::Index kRows = 256;  // in one matrix product
constexpr double kShrinkage = 0.2;
constexpr Eigen::Index kDirections = 40;
constexpr Eigen::Index kLoadings = 30;
constexpr Eigen::Index kAligned = 48;       // directions in which clips are aligned
constexpr std::int64_t kMaxFrames = 65536;  // for the covariance of all motion
// Maximum number of differences. Adjacent frames are similar, so every second one is skipped first.
constexpr double kMaxDifferences = 65536;
constexpr double kMinNoise = 1e-4;
constexpr double kMinVariance = 1e-8;  // if all clips of a label are equal

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

// Sum of row^T row, and the number of rows.
struct Scatter {
  Eigen::MatrixXd sum;
  double rows = 0;

  void Add(const FrameMatrix& differences) {
    for (Eigen::Index r = 0; r < differences.rows(); r += kRows) {
      const auto block = differences.middleRows(r, std::min(kRows, differences.rows() - r));
      Eigen::MatrixXf squares = Eigen::MatrixXf::Zero(block.cols(), block.cols());
      squares.selfadjointView<Eigen::Lower>().rankUpdate(block.transpose());
      sum += squares.cast<double>();
    }
    rows += static_cast<double>(differences.rows());
  }
};

// Calls body(part, scatter) for each part. Returns the total, summed in the order of the parts.
Scatter SumParts(Eigen::Index dimensions, const ParallelFor& parallel,
                 const std::function<void(int, Scatter&)>& body) {
  std::vector<Scatter> scatters(kParts);
  parallel(kParts, [&](int part) {
    scatters[part].sum.setZero(dimensions, dimensions);
    body(part, scatters[part]);
  });
  for (int part = 1; part < kParts; ++part) {
    scatters[0].sum += scatters[part].sum;
    scatters[0].rows += scatters[part].rows;
  }
  scatters[0].sum = scatters[0].sum.selfadjointView<Eigen::Lower>();
  return std::move(scatters[0]);
}

// The strided frames from which the metric is learned, relative to their mean. Frames with kept
// glitches are replaced by the mean, so that they have no effect.
class LearnedFrames {
 public:
  explicit LearnedFrames(const ModelParts& parts)
      : strided_(StrideFrames(parts.clips, parts.settings.frame_rate_hz)),
        states_(parts.states.view()),
        is_glitch_(strided_.frame.size()) {
    for (std::size_t c = 0; c < parts.clips.size(); ++c) {
      if (parts.clips[c].glitches.empty()) continue;
      for (int row = strided_.begin[c]; row < strided_.begin[c + 1]; ++row) {
        is_glitch_[row] = parts.clips[c].HasGlitch(strided_.frame[row], strided_.frame[row]);
      }
    }
    sampled_ = SpreadEvenly(std::ssize(strided_.frame), kMaxFrames);
  }

  // Computes the mean of the sampled frames.
  const Eigen::RowVectorXf& FindMean(const ParallelFor& parallel) {
    const auto dimensions = static_cast<int>(states_.cols());
    std::vector<Eigen::RowVectorXd> sums(kParts);
    std::vector<int> counts(kParts);
    parallel(kParts, [&](int part) {
      sums[part].setZero(dimensions);
      for (const int row : PartSample(part)) {
        if (is_glitch_[row]) continue;
        sums[part] += states_.row(strided_.frame[row]).cast<double>();
        ++counts[part];
      }
    });
    for (int part = 1; part < kParts; ++part) {
      sums[0] += sums[part];
      counts[0] += counts[part];
    }
    mean_ = (sums[0] / std::max(1, counts[0])).cast<float>();
    return mean_;
  }

  // Returns the covariance of the sampled frames.
  Eigen::MatrixXd Covariance(const ParallelFor& parallel) const {
    const Scatter scatter = SumParts(states_.cols(), parallel, [&](int part, Scatter& sum) {
      const std::span<const int> rows = PartSample(part);
      for (std::size_t r = 0; r < rows.size(); r += kRows) {
        sum.Add(Rows(rows.subspan(r, std::min<std::size_t>(kRows, rows.size() - r))));
      }
    });
    return scatter.sum / std::max(1.0, scatter.rows - 1);
  }

  FrameMatrix ClipFrames(int clip) const { return FramesOf(strided_.of_clip(clip)); }

  FrameMatrix FramesOf(const RowRange& range) const {
    std::vector<int> rows(range.count);
    std::iota(rows.begin(), rows.end(), range.first);
    return Rows(rows);
  }

 private:
  FrameMatrix Rows(std::span<const int> rows) const {
    FrameMatrix frames(std::ssize(rows), states_.cols());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto to = static_cast<Eigen::Index>(r);
      if (is_glitch_[rows[r]]) {
        frames.row(to).setZero();
      } else {
        frames.row(to) = states_.row(strided_.frame[rows[r]]) - mean_;
      }
    }
    return frames;
  }
  std::span<const int> PartSample(int part) const {
    const std::size_t begin = part * sampled_.size() / kParts;
    return std::span(sampled_).subspan(begin, (part + 1) * sampled_.size() / kParts - begin);
  }

  StridedFrames strided_;
  Eigen::Map<const FrameMatrix> states_;
  std::vector<char> is_glitch_;  // for each strided frame
  std::vector<int> sampled_;
  Eigen::RowVectorXf mean_;
};

// Pairs of units to align, and the stride of the frames whose differences are used: 1, or 2 if
// there are more than kMaxDifferences.
struct Comparisons {
  std::vector<IndexPair> units;
  int pair_stride = 1;
};

Comparisons ChooseComparisons(const std::vector<LabelUnit>& units) {
  constexpr int kMinReferences = 2;
  constexpr int kMaxReferences = 8;
  Comparisons chosen{UnitPairs(units, kMaxReferences)};
  double differences = 0;
  for (const IndexPair& pair : chosen.units) differences += units[pair.observed].rows.count;
  if (differences <= kMaxDifferences) return chosen;
  chosen.pair_stride = 2;
  const double share = kMaxDifferences * chosen.pair_stride / differences;
  if (share >= 1) return chosen;
  chosen.units = UnitPairs(
      units, std::max(kMinReferences, static_cast<int>(std::lround(share * kMaxReferences))));
  return chosen;
}

// Returns W, half the mean of d d^T. d is the difference between corresponding frames of two units
// of one label. Units are aligned in the directions (D x q) with the largest variance.
Eigen::MatrixXd WithinBehaviours(const ModelParts& parts, const LearnedFrames& frames,
                                 const FrameMatrix& directions, const ParallelFor& parallel) {
  const LabelUnits units(parts.clips, parts.settings.frame_rate_hz, kActionTrack);
  const Comparisons chosen = ChooseComparisons(units.all());
  const std::vector<IndexPair>& pairs = chosen.units;
  const std::size_t count = pairs.size();
  const int stride = chosen.pair_stride;
  Scatter scatter = SumParts(directions.rows(), parallel, [&](int part, Scatter& sum) {
    int unit = -1;
    FrameMatrix observed;
    FrameMatrix observed_projected;
    for (std::size_t p = part * count / kParts; p < (part + 1) * count / kParts; ++p) {
      if (unit != pairs[p].observed) {
        unit = pairs[p].observed;
        observed = frames.FramesOf(units.all()[unit].rows);
        observed_projected = RowProduct(observed, directions);
      }
      const FrameMatrix reference = frames.FramesOf(units.all()[pairs[p].reference].rows);
      const std::vector<IndexPair> aligned =
          AlignFrames(observed_projected, RowProduct(reference, directions), directions.rows());
      FrameMatrix differences((std::ssize(aligned) + stride - 1) / stride, directions.rows());
      for (Eigen::Index i = 0; i < differences.rows(); ++i) {
        const IndexPair& pair = aligned[i * stride];
        differences.row(i) = observed.row(pair.observed) - reference.row(pair.reference);
      }
      sum.Add(differences);
    }
  });
  if (scatter.rows == 0) {
    scatter = SumParts(directions.rows(), parallel, [&](int part, Scatter& sum) {
      for (std::size_t c = part; c < parts.clips.size(); c += kParts) {
        const FrameMatrix clip = frames.ClipFrames(static_cast<int>(c));
        sum.Add(clip.bottomRows(clip.rows() - 1) - clip.topRows(clip.rows() - 1));
      }
    });
  }
  return scatter.sum / (2 * std::max(1.0, scatter.rows));
}

}  // namespace

MotionMetric FitMotionMetric(const ModelParts& parts, const ParallelFor& parallel) {
  LearnedFrames frames(parts);
  const Eigen::Index dimensions = parts.states.cols();
  MotionMetric metric;
  metric.mean = frames.FindMean(parallel);

  const Eigen::MatrixXd all = frames.Covariance(parallel);
  const Solver all_solver(all);
  const Eigen::Index loadings = std::min(kLoadings, dimensions - 1);
  const Eigen::VectorXd& variances = all_solver.eigenvalues();  // ascending
  metric.noise = std::max(variances.head(dimensions - loadings).mean(), kMinNoise);
  metric.loadings =
      (all_solver.eigenvectors().rightCols(loadings) *
       (variances.tail(loadings).array() - metric.noise).max(0).sqrt().matrix().asDiagonal())
          .cast<float>();

  const FrameMatrix directions =
      all_solver.eigenvectors().rightCols(std::min(kAligned, dimensions)).cast<float>();
  Eigen::MatrixXd within = WithinBehaviours(parts, frames, directions, parallel);
  const double ridge =
      std::max(kShrinkage * within.trace() / static_cast<double>(dimensions), kMinVariance);
  within *= 1 - kShrinkage;
  within.diagonal().array() += ridge;
  const Solver within_solver(within);
  const Eigen::MatrixXd whitening =
      within_solver.eigenvectors() *
      within_solver.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  const Solver whitened_solver(whitening.transpose() * all * whitening);
  metric.whitening = whitening.cast<float>();
  metric.projection =
      (whitening * whitened_solver.eigenvectors().rightCols(std::min(kDirections, dimensions)))
          .cast<float>();
  return metric;
}

}  // namespace motiondb::core
