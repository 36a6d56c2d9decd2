// A few of many, spread evenly. Pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace motiondb::core {

// At most `most` of `count` indices, ascending; none where either is not above 0.
inline std::vector<int> SpreadEvenly(std::int64_t count, std::int64_t most) {
  const std::int64_t kept = std::min(count, most);
  std::vector<int> spread;
  for (std::int64_t i = 0; i < kept; ++i) spread.push_back(static_cast<int>(i * count / kept));
  return spread;
}

}  // namespace motiondb::core
