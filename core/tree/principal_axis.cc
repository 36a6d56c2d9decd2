#include "core/tree/principal_axis.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/tree/row_kernels.h"

namespace motiondb::core {

namespace {

constexpr Eigen::Index kBasisGrowth = 16;
// Below this fraction of the largest eigenvalue a new direction is rounding: the space is
// exhausted.
constexpr double kExhausted = 1e-14;
// Reorthogonalise a second time if the first pass leaves less than this fraction.
constexpr double kSecondPass = 0.1;

void FixSign(Eigen::VectorXd& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
}

}  // namespace

PrincipalAxis FindPrincipalAxis(const SymmetricProduct& product, const Eigen::VectorXd& start,
                                double tolerance) {
  const Eigen::Index dimensions = start.size();
  // An orthonormal basis of the Krylov space, in which C is the tridiagonal (alpha, beta).
  Eigen::MatrixXd basis(dimensions, std::min(kBasisGrowth, dimensions));
  std::vector<double> alpha;
  std::vector<double> beta;
  PrincipalAxis found;
  Eigen::VectorXd q = start.normalized();
  Eigen::VectorXd w(dimensions);
  Eigen::VectorXd overlap;
  for (Eigen::Index k = 0;; ++k) {
    if (k == basis.cols()) {
      basis.conservativeResize(Eigen::NoChange, std::min(2 * basis.cols(), dimensions));
    }
    basis.col(k) = q;
    product(q, w);
    alpha.push_back(q.dot(w));
    double length = w.norm();
    const auto so_far = basis.leftCols(k + 1);
    for (int pass = 0; pass < 2; ++pass) {
      overlap.noalias() = so_far.transpose() * w;
      w.noalias() -= so_far * overlap;
      const double before = std::exchange(length, w.norm());
      if (length > kSecondPass * before) break;
    }
    beta.push_back(length);

    const TridiagonalTop top = TopOfTridiagonal(alpha, beta);
    found.variance = top.value;
    found.residual = top.value > 0 ? length * std::abs(top.vector[k]) / top.value : 0;
    const bool exhausted = length <= kExhausted * top.value || k + 1 == dimensions;
    if (exhausted || found.residual <= tolerance) {
      found.products = static_cast<int>(k) + 1;
      found.axis = (so_far * top.vector).normalized();
      FixSign(found.axis);
      return found;
    }
    q = w / length;
  }
}

namespace {

constexpr int kMaxIterations = 60;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTiny = kEpsilon * kEpsilon;  // replaces zero, relative to the matrix's scale

// Upper bound of the eigenvalues (Gershgorin).
double UpperBound(std::span<const double> diagonal, std::span<const double> beside) {
  double bound = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double before = i > 0 ? std::abs(beside[i - 1]) : 0;
    const double after = i + 1 < diagonal.size() ? std::abs(beside[i]) : 0;
    bound = std::max(bound, diagonal[i] + before + after);
  }
  return bound;
}

// Pivots at a value above the largest eigenvalue are negative, except for rounding.
double Negative(double pivot, double scale) { return std::min(pivot, -kTiny * scale); }

double NotZero(double pivot, double scale) { return pivot == 0 ? kTiny * scale : pivot; }

double LargestEigenvalue(std::span<const double> diagonal, std::span<const double> beside) {
  const double bound = UpperBound(diagonal, beside);
  const double scale = std::abs(bound);
  const auto size = static_cast<double>(diagonal.size());
  double value = bound + 4 * kEpsilon * scale;
  for (int i = 0; i < kMaxIterations; ++i) {
    // The pivots of T - value I with derivatives, and the first two derivatives of the logarithm of
    // their product (the second with its sign changed).
    double pivot = Negative(diagonal[0] - value, scale);
    double slope = -1;
    double curvature = 0;
    double first = slope / pivot;
    double second = first * first;
    for (std::size_t k = 1; k < diagonal.size(); ++k) {
      const double ratio = beside[k - 1] / pivot;
      const double relative = slope / pivot;
      curvature = ratio * ratio * (curvature - 2 * relative * slope);
      slope = -1 + ratio * ratio * slope;
      pivot = Negative(diagonal[k] - value - ratio * beside[k - 1], scale);
      first += slope / pivot;
      second += (slope / pivot) * (slope / pivot) - curvature / pivot;
    }
    const double root = std::sqrt(std::max(0.0, (size - 1) * (size * second - first * first)));
    const double step = size / (first + root);
    value -= step;
    if (!(step > 2 * kEpsilon * scale)) break;
  }
  return value;
}

Eigen::VectorXd EigenvectorOf(double value, std::span<const double> diagonal,
                              std::span<const double> beside) {
  const auto size = static_cast<int>(diagonal.size());
  const double scale = std::abs(value);
  Eigen::VectorXd down(size);  // pivots from the first row
  Eigen::VectorXd up(size);    // pivots from the last row
  down[0] = NotZero(diagonal[0] - value, scale);
  for (int i = 1; i < size; ++i) {
    down[i] = NotZero(diagonal[i] - value - beside[i - 1] * beside[i - 1] / down[i - 1], scale);
  }
  up[size - 1] = NotZero(diagonal[size - 1] - value, scale);
  for (int i = size - 2; i >= 0; --i) {
    up[i] = NotZero(diagonal[i] - value - beside[i] * beside[i] / up[i + 1], scale);
  }
  int meet = 0;
  double min_mismatch = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size; ++i) {
    const double mismatch = std::abs(down[i] + up[i] - (diagonal[i] - value));
    if (mismatch < min_mismatch) {
      min_mismatch = mismatch;
      meet = i;
    }
  }
  Eigen::VectorXd vector(size);
  vector[meet] = 1;
  for (int i = meet - 1; i >= 0; --i) vector[i] = -beside[i] * vector[i + 1] / down[i];
  for (int i = meet + 1; i < size; ++i) vector[i] = -beside[i - 1] * vector[i - 1] / up[i];
  return vector.normalized();
}

}  // namespace

TridiagonalTop TopOfTridiagonal(std::span<const double> diagonal, std::span<const double> beside) {
  if (diagonal.size() == 1) return {diagonal[0], Eigen::VectorXd::Ones(1)};
  const double value = LargestEigenvalue(diagonal, beside);
  return {value, EigenvectorOf(value, diagonal, beside)};
}

namespace {

// Number of frames that are copied and centred: all of a small node, a sample of a larger one.
constexpr int kCopiedFrames = 4096;
constexpr double kSubsetTolerance = 1e-3;
constexpr int kWidestFrames = 64;  // sample for the dimension with the largest variance

// The rows of a large node are summed in up to kMaxRuns parallel runs. Runs depend on the node
// only, not on threads, so that sums are identical.
constexpr int kMaxRuns = 16;
constexpr int kMinRunRows = 2048;
constexpr int kBlockRows = 256;  // the first product reads them twice, the second time from cache

// Index of the r-th of `count` rows spread evenly over `all` rows.
int EvenIndex(int r, int count, int all) { return static_cast<int>(std::int64_t{all} * r / count); }

// Returns the sum over a node's rows of `length` numbers; `add_rows` adds those of a run.
template <typename AddRowsOfRun>
Eigen::VectorXd SumOverRuns(const NodeRows& rows, Eigen::Index length, const ParallelFor& parallel,
                            const AddRowsOfRun& add_rows) {
  const int runs = std::clamp(rows.count / kMinRunRows, 1, kMaxRuns);
  std::vector<Eigen::VectorXd> partial(static_cast<std::size_t>(runs));
  parallel(runs, [&](int run) {
    const int begin = EvenIndex(run, runs, rows.count);
    const int end = EvenIndex(run + 1, runs, rows.count);
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

// Returns the product with the scatter matrix of centred rows (count x padded).
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

// Returns the scatter matrix times the unit vector of the dimension with the largest variance over
// a sample of the centred rows: it leans towards the leading axis.
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

// Returns the axis of `count` rows; `centred` receives their copy, centred about `mean`.
PrincipalAxis AxisOfSome(const NodeRows& rows, int count, const Eigen::VectorXd& mean,
                         double tolerance, std::vector<float>& centred) {
  const int padded = PaddedDimensions(rows.dimensions);
  const auto needed = static_cast<std::size_t>(count) * padded;
  if (centred.size() < needed) centred.resize(needed);
  const Eigen::VectorXf single_mean = mean.cast<float>();
  for (int r = 0; r < count; ++r) {
    CentreRows(rows.row(EvenIndex(r, count, rows.count)), 1, rows.dimensions, single_mean.data(),
               centred.data() + static_cast<std::ptrdiff_t>(r) * padded);
  }
  const SymmetricProduct scatter = ScatterOf(centred.data(), count, rows.dimensions);
  return FindPrincipalAxis(
      scatter, WidestDimension(centred.data(), count, rows.dimensions, scatter), tolerance);
}

// Products with the scatter matrix of all rows of a large node. The mean is known only after the
// first product, which uses the mean of a sample instead.
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
    // Layout: sum of s x, sum of s, and, until the mean is known, sum of x.
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
  // AddScatterProduct of the last rows of a run, from a copy: vector steps read beyond the last
  // row, where other threads may move rows of another node.
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
    AddRows(rows.row(EvenIndex(r, count, rows.count)), 1, rows.dimensions, sum.data());
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
