#include "core/format/frame_rate.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace motiondb::core {

bool IsFrameRate(double rate_hz) { return rate_hz >= 1e-3 && rate_hz <= 1e5; }

double SnapFrameRate(double rate_hz, std::vector<std::string>& notes) {
  constexpr double kClose = 1e-3;
  constexpr double kWorthSaying = 1e-6;
  constexpr std::array<double, 4> kBroadcast = {24000.0 / 1001, 30000.0 / 1001, 60000.0 / 1001,
                                                120000.0 / 1001};
  double nearest = std::round(rate_hz);
  for (const double rate : kBroadcast) {
    if (std::abs(rate - rate_hz) < std::abs(nearest - rate_hz)) nearest = rate;
  }
  const double difference = std::abs(nearest - rate_hz) / rate_hz;
  if (nearest <= 0 || difference > kClose) return rate_hz;
  if (difference > kWorthSaying) {
    notes.push_back(fmt::format("frame rate {:.8g} Hz taken for {:.8g} Hz", rate_hz, nearest));
  }
  return nearest;
}

}  // namespace motiondb::core
