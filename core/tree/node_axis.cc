#include "core/tree/node_axis.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/tree/row_kernels.h"

namespace motiondb::core {
namespace {

// A node of up to this many frames is copied, centred; of a larger one, this many of its frames.
constexpr int kCopiedFrames = 4096;
constexpr double kSubsetTolerance = 1e-3;
constexpr int kWidestFrames = 64;  // of which the dimension that varies most is taken

// The rows of a large node are summed in this many runs at most, side by side. The division depends
// on the node alone, never on the threads: the sums come out the same.
constexpr int kMaxRuns = 16;
constexpr int kMinRunRows = 2048;
constexpr int kBlockRows = 256;  // the first product reads them twice, again from a cache

// The r-th of `count` rows spread evenly over all.
int Spread(int r, int count, int all) { return static_cast<int>(std::int64_t{all} * r / count); }

// Sums over a node's rows of something of `length` numbers, which `add_rows` adds for a run of
// them.
template <typename AddRowsOfRun>
Eigen::VectorXd SumOverRuns(const NodeRows& rows, Eigen::Index length, const ParallelFor& parallel,
                            const AddRowsOfRun& add_rows) {
  const int runs = std::clamp(rows.count / kMinRunRows, 1, kMaxRuns);
  std::vector<Eigen::VectorXd> partial(static_cast<std::size_t>(runs));
  parallel(runs, [&](int run) {
    const int begin = Spread(run, runs, rows.count);
    const int end = Spread(run + 1, runs, rows.count);
    partial[run] = Eigen::VectorXd::Zero(length);
    add_rows(NodeRows{rows.row(begin), end - begin, rows.dimensions}, partial[run].data());
  });
  for (int run = 1; run < runs; ++run) partial[0] += partial[run];
  return std::move(partial[0]);
}

// A vector in single precision, padded with zeros.
void ToPadded(const Eigen::VectorXd& from, std::vector<float>& to) {
  to.assign(static_cast<std::size_t>(PaddedDimensions(static_cast<int>(from.size()))), 0);
  Eigen::VectorXf::Map(to.data(), from.size()) = from.cast<float>();
}

// Products with the scatter matrix of centred rows (count x padded).
SymmetricProduct ScatterOf(const float* centred, int count, int dimensions) {
  return [=, padded_q = std::vector<float>(), sums = Eigen::VectorXd()](
             const Eigen::VectorXd& q, Eigen::VectorXd& product) mutable {
    ToPadded(q, padded_q);
    const auto padded = static_cast<int>(padded_q.size());
    sums.setZero(padded);
    AddScatterProduct(centred, count, padded, padded, padded_q.data(), 0, sums.data());
    product = sums.head(dimensions);
  };
}

// The dimension that varies most over some of the centred rows, times their scatter matrix: it
// leans towards the leading axis.
Eigen::VectorXd WidestDimension(const float* centred, int count, int dimensions,
                                const SymmetricProduct& product) {
  const int step = (count + kWidestFrames - 1) / kWidestFrames;
  Eigen::RowVectorXf squares = Eigen::RowVectorXf::Zero(dimensions);
  for (int r = 0; r < count; r += step) {
    const float* row = centred + std::ptrdiff_t{r} * PaddedDimensions(dimensions);
    squares += Eigen::RowVectorXf::Map(row, dimensions).cwiseAbs2();
  }
  Eigen::Index widest = 0;
  squares.maxCoeff(&widest);
  Eigen::VectorXd start(dimensions);
  product(Eigen::VectorXd::Unit(dimensions, widest), start);
  if (!(start.squaredNorm() > 0)) start = Eigen::VectorXd::Unit(dimensions, 0);
  return start;
}

// The axis of some rows, of which `centred` keeps a copy about `mean`.
PrincipalAxis AxisOfSome(const NodeRows& rows, int count, const Eigen::VectorXd& mean,
                         double tolerance, std::vector<float>& centred) {
  const int padded = PaddedDimensions(rows.dimensions);
  const auto needed = static_cast<std::size_t>(count) * padded;
  if (centred.size() < needed) centred.resize(needed);
  const Eigen::VectorXf single_mean = mean.cast<float>();
  for (int r = 0; r < count; ++r) {
    CentreRows(rows.row(Spread(r, count, rows.count)), 1, rows.dimensions, single_mean.data(),
               centred.data() + static_cast<std::ptrdiff_t>(r) * padded);
  }
  const SymmetricProduct scatter = ScatterOf(centred.data(), count, rows.dimensions);
  return FindPrincipalAxis(
      scatter, WidestDimension(centred.data(), count, rows.dimensions, scatter), tolerance);
}

// Products with the scatter matrix of all rows of a large node, about a mean that is not known
// before the first of them: until then that of a few rows serves.
class ScatterOfLarge {
 public:
  ScatterOfLarge(const NodeRows& rows, const Eigen::VectorXd& mean_of_some,
                 const ParallelFor& parallel)
      : rows_(rows), mean_(mean_of_some), parallel_(parallel) {}

  void Multiply(const Eigen::VectorXd& q, Eigen::VectorXd& product) {
    const int dimensions = rows_.dimensions;
    const int padded = PaddedDimensions(dimensions);
    ToPadded(q, padded_q_);
    const auto offset = static_cast<float>(mean_.dot(q));
    // The sum of s x, then that of s, then that of x where it is not known yet.
    const Eigen::VectorXd sums = SumOverRuns(
        rows_, padded + 1 + (mean_known_ ? 0 : dimensions), parallel_,
        [&](const NodeRows& run, double* sum) {
          for (int r = 0; r < run.count; r += kBlockRows) {
            const int block = std::min(kBlockRows, run.count - r);
            sum[padded] += r + block < run.count
                               ? AddScatterProduct(run.row(r), block, dimensions, padded,
                                                   padded_q_.data(), offset, sum)
                               : AddLastBlock(run.row(r), block, offset, sum);
            if (!mean_known_) AddRows(run.row(r), block, dimensions, sum + padded + 1);
          }
        });
    if (!mean_known_) mean_ = sums.tail(dimensions) / rows_.count;
    mean_known_ = true;
    product = sums.head(dimensions) - sums[padded] * mean_;
  }

  const Eigen::VectorXd& mean() const { return mean_; }

 private:
  // AddScatterProduct of the last rows of a run, from a copy: steps over a row's end read what is
  // behind it, where other threads may be moving the rows of another node.
  double AddLastBlock(const float* rows, int count, float offset, double* sum) const {
    const int padded = PaddedDimensions(rows_.dimensions);
    const std::vector<float> zeros(static_cast<std::size_t>(rows_.dimensions));
    std::vector<float> copy(static_cast<std::size_t>(count) * padded);
    CentreRows(rows, count, rows_.dimensions, zeros.data(), copy.data());
    return AddScatterProduct(copy.data(), count, padded, padded, padded_q_.data(), offset, sum);
  }

  const NodeRows& rows_;
  Eigen::VectorXd mean_;
  bool mean_known_ = false;
  const ParallelFor& parallel_;
  std::vector<float> padded_q_;
};

Eigen::VectorXd MeanOfSome(const NodeRows& rows, int count) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows.dimensions);
  for (int r = 0; r < count; ++r) {
    AddRows(rows.row(Spread(r, count, rows.count)), 1, rows.dimensions, sum.data());
  }
  return sum / count;
}

}  // namespace

NodeAxis FindNodeAxis(const NodeRows& rows, std::vector<float>& centred,
                      const ParallelFor& parallel) {
  if (rows.count <= kCopiedFrames) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows.dimensions);
    AddRows(rows.data, rows.count, rows.dimensions, sum.data());
    const Eigen::VectorXd mean = sum / rows.count;
    return {mean, AxisOfSome(rows, rows.count, mean, kTightTolerance, centred)};
  }
  const Eigen::VectorXd mean = MeanOfSome(rows, kCopiedFrames);
  const PrincipalAxis near = AxisOfSome(rows, kCopiedFrames, mean, kSubsetTolerance, centred);
  ScatterOfLarge scatter(rows, mean, parallel);
  PrincipalAxis axis = FindPrincipalAxis(
      [&](const Eigen::VectorXd& q, Eigen::VectorXd& product) { scatter.Multiply(q, product); },
      near.axis, rows.count <= kTightFrames ? kTightTolerance : kLooseTolerance);
  return {scatter.mean(), std::move(axis)};
}

}  // namespace motiondb::core
