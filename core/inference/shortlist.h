// Which clips are worth aligning with a window: those whose graphs explain it best. Pure.
#pragma once

#include <algorithm>
#include <vector>

#include "core/inference/recognize.h"

namespace motiondb::core {

// The 32 first of scores that are sorted, most probable first.
inline std::vector<int> Shortlist(const std::vector<ClipScore>& sorted) {
  constexpr std::size_t kMost = 32;
  std::vector<int> clips;
  for (std::size_t i = 0; i < std::min(kMost, sorted.size()); ++i) clips.push_back(sorted[i].clip);
  return clips;
}

}  // namespace motiondb::core
