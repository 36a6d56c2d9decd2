#include "core/tree/tridiagonal.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motiondb::core {
namespace {

constexpr int kMaxIterations = 60;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kTiny = kEpsilon * kEpsilon;  // what stands for zero, of the matrix's scale

// A bound on every eigenvalue (Gershgorin).
double UpperBound(std::span<const double> diagonal, std::span<const double> beside) {
  double bound = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double before = i > 0 ? std::abs(beside[i - 1]) : 0;
    const double after = i + 1 < diagonal.size() ? std::abs(beside[i]) : 0;
    bound = std::max(bound, diagonal[i] + before + after);
  }
  return bound;
}

// A pivot above the largest eigenvalue is negative; rounding may have it otherwise.
double Negative(double pivot, double scale) { return std::min(pivot, -kTiny * scale); }

double NotZero(double pivot, double scale) { return pivot == 0 ? kTiny * scale : pivot; }

double LargestEigenvalue(std::span<const double> diagonal, std::span<const double> beside) {
  const double bound = UpperBound(diagonal, beside);
  const double scale = std::abs(bound);
  const auto size = static_cast<double>(diagonal.size());
  double value = bound + 4 * kEpsilon * scale;
  for (int i = 0; i < kMaxIterations; ++i) {
    // The pivots of T - value I with their derivatives, and the first two derivatives of the
    // logarithm of their product (the second with its sign changed).
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
  Eigen::VectorXd up(size);    // and from the last
  down[0] = NotZero(diagonal[0] - value, scale);
  for (int i = 1; i < size; ++i) {
    down[i] = NotZero(diagonal[i] - value - beside[i - 1] * beside[i - 1] / down[i - 1], scale);
  }
  up[size - 1] = NotZero(diagonal[size - 1] - value, scale);
  for (int i = size - 2; i >= 0; --i) {
    up[i] = NotZero(diagonal[i] - value - beside[i] * beside[i] / up[i + 1], scale);
  }
  int meet = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size; ++i) {
    const double apart = std::abs(down[i] + up[i] - (diagonal[i] - value));
    if (apart < least) {
      least = apart;
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

}  // namespace motiondb::core
