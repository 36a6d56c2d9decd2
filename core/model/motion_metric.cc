#include "core/model/motion_metric.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "core/model/frame_pairs.h"
#include "core/model/metric_frames.h"
#include "core/model/model.h"

namespace motiondb::core {
namespace {

constexpr int kParts = 16;           // of the sums, whatever the threads
constexpr Eigen::Index kRows = 256;  // summed at a time, as fast as a matrix product
constexpr double kShrinkage = 0.2;
constexpr Eigen::Index kDirections = 40;
constexpr Eigen::Index kLoadings = 30;
constexpr double kLeastNoise = 1e-4;
constexpr double kLeastVariance = 1e-8;  // where stored clips of one label are all the same

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

// The sum of row^T row, and of how many.
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

// body(part, scatter) for each part; the parts' sums together, in order.
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

Eigen::MatrixXd Covariance(const FrameMatrix& centred, const ParallelFor& parallel) {
  const Scatter scatter = SumParts(centred.cols(), parallel, [&](int part, Scatter& sum) {
    const Eigen::Index begin = part * centred.rows() / kParts;
    sum.Add(centred.middleRows(begin, (part + 1) * centred.rows() / kParts - begin));
  });
  return scatter.sum / std::max(1.0, scatter.rows - 1);
}

// The rows of frames that kept glitches are in.
std::vector<Eigen::Index> RowsOfGlitches(const std::vector<ModelClip>& clips,
                                         const StridedFrames& strided) {
  std::vector<Eigen::Index> rows;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    if (clips[c].glitches.empty()) continue;
    for (int row = strided.begin[c]; row < strided.begin[c + 1]; ++row) {
      if (clips[c].HasGlitch(strided.frame[row], strided.frame[row])) rows.push_back(row);
    }
  }
  return rows;
}

// W: half the mean of d d^T, d from a frame to its like in another clip of the label.
Eigen::MatrixXd WithinBehaviours(const ModelParts& parts, const StridedFrames& strided,
                                 const FrameMatrix& centred, const ParallelFor& parallel) {
  const std::vector<IndexPair> pairs = ClipPairs(parts.clips);
  const auto rows_of = [&](int clip) -> FrameMatrix {
    return centred.middleRows(strided.begin[clip], strided.count(clip));
  };
  Scatter scatter = SumParts(centred.cols(), parallel, [&](int part, Scatter& sum) {
    for (std::size_t p = part; p < pairs.size(); p += kParts) {
      const FrameMatrix observed = rows_of(pairs[p].observed);
      const FrameMatrix reference = rows_of(pairs[p].reference);
      const std::vector<IndexPair> like = AlignFrames(observed, reference);
      FrameMatrix differences(static_cast<Eigen::Index>(like.size()), centred.cols());
      for (std::size_t i = 0; i < like.size(); ++i) {
        differences.row(static_cast<Eigen::Index>(i)) =
            observed.row(like[i].observed) - reference.row(like[i].reference);
      }
      sum.Add(differences);
    }
  });
  if (scatter.rows == 0) {
    scatter = SumParts(centred.cols(), parallel, [&](int part, Scatter& sum) {
      for (std::size_t c = part; c < parts.clips.size(); c += kParts) {
        const FrameMatrix clip = rows_of(static_cast<int>(c));
        sum.Add(clip.bottomRows(clip.rows() - 1) - clip.topRows(clip.rows() - 1));
      }
    });
  }
  return scatter.sum / (2 * std::max(1.0, scatter.rows));
}

}  // namespace

MotionMetric FitMotionMetric(const ModelParts& parts, const ParallelFor& parallel) {
  const StridedFrames strided = StrideFrames(parts.clips, parts.settings.frame_rate_hz);
  FrameMatrix frames = parts.states.view()(strided.frame, Eigen::all);
  const Eigen::Index dimensions = frames.cols();
  MotionMetric metric;
  const std::vector<Eigen::Index> glitches = RowsOfGlitches(parts.clips, strided);
  for (const Eigen::Index row : glitches) frames.row(row).setZero();
  const auto sound =
      static_cast<double>(std::max(std::ssize(glitches) + 1, frames.rows()) - std::ssize(glitches));
  metric.mean = (frames.cast<double>().colwise().sum() / sound).cast<float>();
  frames.rowwise() -= metric.mean;
  for (const Eigen::Index row : glitches)
    frames.row(row).setZero();  // as the mean, they say nothing

  const Eigen::MatrixXd all = Covariance(frames, parallel);
  const Solver of_all(all);
  const Eigen::Index loadings = std::min(kLoadings, dimensions - 1);
  const Eigen::VectorXd& variances = of_all.eigenvalues();  // ascending
  metric.noise = std::max(variances.head(dimensions - loadings).mean(), kLeastNoise);
  metric.loadings =
      (of_all.eigenvectors().rightCols(loadings) *
       (variances.tail(loadings).array() - metric.noise).max(0).sqrt().matrix().asDiagonal())
          .cast<float>();

  Eigen::MatrixXd within = WithinBehaviours(parts, strided, frames, parallel);
  const double ridge =
      std::max(kShrinkage * within.trace() / static_cast<double>(dimensions), kLeastVariance);
  within *= 1 - kShrinkage;
  within.diagonal().array() += ridge;
  const Solver of_within(within);
  const Eigen::MatrixXd whitening =
      of_within.eigenvectors() * of_within.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  const Solver of_whitened(whitening.transpose() * all * whitening);
  metric.whitening = whitening.cast<float>();
  metric.projection =
      (whitening * of_whitened.eigenvectors().rightCols(std::min(kDirections, dimensions)))
          .cast<float>();
  return metric;
}

}  // namespace motiondb::core
