// Timing of a path: as recorded, but slower where a coordinate would be too fast.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/motion/matrix.h"

namespace motiondb::core {

// Maximum speed and acceleration of each coordinate, 1 x coordinates each; infinite: no limit.
struct RateLimits {
  Eigen::RowVectorXd speed;         // rad/s or m/s
  Eigen::RowVectorXd acceleration;  // rad/s^2 or m/s^2
};

enum class LimitKind { kSpeed, kAcceleration };

// The limit that determines the timing at a place; coordinate -1: none.
struct BindingLimit {
  int coordinate = -1;
  LimitKind kind = LimitKind::kSpeed;

  bool operator==(const BindingLimit&) const = default;
};

// A part of a motion that is slower than recorded.
struct SlowedPart {
  double start_seconds = 0;
  double end_seconds = 0;
  BindingLimit limit;
  double factor = 1;  // largest duration relative to the recorded one, above 1
};

// The time at each place of a uniform cubic B-spline (JointPath): at most the recorded speed,
// and as fast as the limits allow. The place has a continuous speed along the path, which changes
// by the recorded speed in at least 0.2 s.
//
// In the phase plane of place and squared speed x, a coordinate with path derivatives q' and q''
// requires q'^2 x <= v^2 and, with dx the change of x over a distance 2 d, |q''| x + |q'| |dx| / 2d
// <= a. A pass backward and one forward over a grid of two cells for each step keep x below the
// bounds that follow. O(steps * coordinates).
class TimeLaw {
 public:
  // `steps`: of the path, as from PoseSteps, at least 1. `recorded_hz`: poses per second.
  TimeLaw(const JointMatrix& steps, double recorded_hz, const RateLimits& limits);

  double duration_seconds() const { return seconds_.back(); }
  // Whether every place has its recorded speed.
  bool as_recorded() const { return slowed_.empty(); }
  // Returns the place at a time, clamped to the path.
  double PlaceAt(double seconds) const;
  // The slowed parts in order. Parts with a factor below 1.001 are omitted.
  const std::vector<SlowedPart>& slowed() const { return slowed_; }
  // Slows the whole motion by a factor, at least 1.
  void Slow(double factor);

 private:
  void FindSlowedParts(double recorded_hz, const std::vector<BindingLimit>& binding);

  std::vector<double> speeds_;   // of the place at each grid point, steps of the path per second
  std::vector<double> seconds_;  // of each grid point
  std::vector<SlowedPart> slowed_;
};

}  // namespace motiondb::core
