// From stored states to those of a model: scaled, in memory that has room for clips that come
// later. Pure functions; they use only the threads lent to them.
#pragma once

#include <algorithm>
#include <utility>

#include "core/model/shared_rows.h"
#include "core/tree/feature_scale.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Scales the first rows of `states` (rows x dimensions); the last `room` are room for more.
inline SharedRows ScaleRows(const FeatureScale& scale, FrameMatrix states, Eigen::Index room,
                            const ParallelFor& parallel) {
  constexpr int kRowsAtOnce = 1024;
  const auto rows = static_cast<int>(states.rows() - room);
  parallel((rows + kRowsAtOnce - 1) / kRowsAtOnce, [&](int block) {
    const int first = block * kRowsAtOnce;
    states.middleRows(first, std::min(kRowsAtOnce, rows - first)).array().rowwise() /=
        scale.divisor.array();
  });
  return SharedRows(std::move(states), room);
}

}  // namespace motiondb::core
