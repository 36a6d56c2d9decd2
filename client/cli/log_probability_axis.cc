#include "client/cli/log_probability_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace motiondb::client {
namespace {

constexpr double kLinear = 3;                   // about where the scale turns logarithmic
constexpr double kAbove = 0.05, kBelow = 0.04;  // of the axis, around the values

double Scaled(double value) { return std::asinh(value / kLinear); }

}  // namespace

LogProbabilityAxis::LogProbabilityAxis() = default;

void LogProbabilityAxis::Add(double value) {
  if (!std::isfinite(value)) return;
  low_ = std::min(low_, std::max(value, kLowest));
  high_ = std::max(high_, std::min(value, -kLowest));
}

double LogProbabilityAxis::Fraction(double value) const {
  const double span = (Scaled(high_) - Scaled(low_)) / (1 - kAbove - kBelow);
  return kAbove + (Scaled(high_) - Scaled(value)) / span;
}

std::vector<double> LogProbabilityAxis::Ticks(double least) const {
  std::vector<double> below = {0}, above;
  const auto add = [&](std::vector<double>& ticks, double value) {
    const double last = ticks.empty() ? 0 : ticks.back();
    if (std::abs(Fraction(value) - Fraction(last)) >= least) ticks.push_back(value);
  };
  for (double value = 1; - value >= low_; value *= 10) add(below, -value);
  for (double value = 1; value <= high_; value *= 10) add(above, value);
  above.insert(above.end(), below.begin(), below.end());
  std::sort(above.begin(), above.end(), std::greater<>());
  return above;
}

std::string LogProbabilityAxis::TickText(double value) {
  if (std::abs(value) < 1e5) return fmt::format("{:.0f}", value);
  return fmt::format("{}1e{:.0f}", value < 0 ? "-" : "", std::log10(std::abs(value)));
}

}  // namespace motiondb::client
