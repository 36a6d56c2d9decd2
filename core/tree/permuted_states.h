// The states in tree order during a build: every node's frames are contiguous in memory. Different
// threads may work on different nodes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/principal_axis.h"

namespace motiondb::core {

// The plane of a split: frames with an inner product of at most `threshold` with `axis` (1 x
// dimensions, unit) are left; of those exactly on the threshold only the first.
struct SplitPlane {
  Eigen::RowVectorXf axis;
  double threshold = 0;
};

class PermutedStates {
 public:
  // Moves the rows of `states` (frames x dimensions), which must outlive this object.
  explicit PermutedStates(Eigen::Map<FrameMatrix> states);

  // Splits the frames [begin, end) along their principal axis (eqs. 3-5): moves those left of the
  // minimum-error threshold before the others. Equal projections are split by frame number. Returns
  // the number of frames on the left and sets `plane`; returns 0 and changes nothing if either side
  // would have fewer than min_frames. `centred` is scratch. The order within a side is
  // deterministic, but not that of frame numbers.
  int Split(std::int32_t begin, std::int32_t end, int min_frames, std::vector<float>& centred,
            const ParallelFor& parallel, SplitPlane& plane);

  // REQUIRES: Split has just returned 0 for [begin, end). Moves the frames on the smaller side of
  // the threshold to one end, and narrows the range to the others. Returns false and changes
  // nothing if there is no threshold.
  bool ExcludeOutliers(std::int32_t& begin, std::int32_t& end, const ParallelFor& parallel);

  // Moves the rows of the states back to the order of the frames.
  void Restore(const ParallelFor& parallel);

  // Frame number at each place.
  std::vector<std::int32_t>& order() { return order_; }
  auto row(std::int32_t place) const { return rows_.row(place); }

 private:
  void Project(std::int32_t begin, std::int32_t end, const NodeAxis& node,
               const ParallelFor& parallel);
  void MoveLeft(std::int32_t begin, std::int32_t end, int left, const ParallelFor& parallel);

  Eigen::Map<FrameMatrix> rows_;
  std::vector<std::int32_t> order_;
  // By place; valid from one Split to the next.
  std::vector<double> projections_;
  std::vector<double> sorted_;
  std::vector<double> scratch_;
  std::vector<std::int32_t> misplaced_;
};

// Sorts finite values, ascending, deterministic for any number of threads. Bucket sort: O(n) for
// evenly spread values, such as projections of states; O(n log n) at worst. `scratch` has the size
// of `values`.
void SortValues(std::span<double> values, std::span<double> scratch, const ParallelFor& parallel);

}  // namespace motiondb::core
