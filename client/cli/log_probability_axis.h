// An axis for log probabilities, which lie between -1 and many thousands below 0 in one picture: at
// small values nearly linear, beyond about -10 logarithmic (an inverse hyperbolic sine). Plain
// value; pure functions.
#pragma once

#include <string>
#include <vector>

namespace motiondb::client {

class LogProbabilityAxis {
 public:
  // An axis without values, from 0 to -10.
  LogProbabilityAxis();

  // Widens the axis to hold a value, down to kLowest; one that is not finite is passed over.
  void Add(double value);

  // Where a value is: 0 at the upper end, 1 at the lower end.
  double Fraction(double value) const;

  // Whether a value lies below the axis.
  bool IsBelow(double value) const { return value < kLowest; }

  // 0 and powers of ten, above and below, from the top. Near 0 there are only those that are
  // `least` of the axis away from each other.
  std::vector<double> Ticks(double least) const;

  // "0", "-10", "-10000", "-1e5".
  static std::string TickText(double value);

 private:
  static constexpr double kLowest = -1e6;

  double high_ = 0;
  double low_ = -10;
};

}  // namespace motiondb::client
