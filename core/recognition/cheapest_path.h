// The cheapest paths of an observation through a stored clip: dynamic time warping with a free
// start and a free end.
#pragma once

#include <vector>

#include "core/model/metric_frames.h"
#include "core/motion/execution.h"
#include "core/recognition/clip_alignment.h"

namespace motiondb::core {

// Cost of a step that stays on a stored frame or skips one; the step to the next frame is free. As
// in AlignToClip, whose probabilities of these steps are 0.2 and 0.6: 2 * 3 * log(0.6 / 0.2).
inline constexpr float kWarpCost = 6.5917F;

// Rows of a clip on a path: the first to the last one, counted from the clip's first row.
struct PathRows {
  int first = 0;
  int last = 0;
  double cost = 0;  // of the path, divided by the number of observed frames
};

// For one observation and several clips; reuses its memory. Not thread-safe.
class CheapestPaths {
 public:
  // `observed`: frames x K, in the metric, at the rate of the stored rows.
  explicit CheapestPaths(const FrameMatrix& observed) : observed_(observed) {}

  // Finds for each of the stored `rows` the cheapest path that ends there. With each observed frame
  // a path stays, goes to the next row, or skips one. Its cost is the sum of the squared distances
  // and of the steps. Returns false if cancelled: the result is then invalid. O(observed frames *
  // rows * K).
  bool Search(const MetricFrames& stored, RowRange rows, ThrottledCancellation& cancellation);

  // Cost of the cheapest of these paths, divided by the number of observed frames.
  double least_cost() const;
  // Returns at most `max_count` of these paths that share no row, cheapest first: each is the
  // cheapest one that shares no row with those before it; of equal ones, that which ends first.
  std::vector<PathRows> Disjoint(int max_count) const;

 private:
  const ObservedFrames observed_;
  int count_ = 0;
  // After two rows that no path reaches.
  std::vector<float> cost_, next_cost_;
  std::vector<int> start_, next_start_;
  Eigen::ArrayXXf distances_;  // rows x frames of the block
};

}  // namespace motiondb::core
