// Evenly spread samples.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace motiondb::core {

// Returns at most `max_count` of the indices 0 to count - 1, evenly spread, ascending. Empty if
// either number is not positive.
inline std::vector<int> SpreadEvenly(std::int64_t count, std::int64_t max_count) {
  const std::int64_t kept = std::min(count, max_count);
  std::vector<int> spread;
  for (std::int64_t i = 0; i < kept; ++i) spread.push_back(static_cast<int>(i * count / kept));
  return spread;
}

}  // namespace motiondb::core
