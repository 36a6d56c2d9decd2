// The states in the order of the tree as it is being built: every node's frames one after the other
// in memory. Different nodes may be worked on by different threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/matrix.h"
#include "core/tree/parallel.h"
#include "core/tree/principal_axis.h"

namespace motiondb::core {

// Where a node was divided: frames with an inner product of at most `threshold` with `axis` (1 x
// dimensions, unit) are on the left; of those on the threshold itself only the first.
struct SplitPlane {
  Eigen::RowVectorXf axis;
  double threshold = 0;
};

class PermutedStates {
 public:
  // Moves the rows of `states` (frames x dimensions), which must outlive this.
  explicit PermutedStates(Eigen::Map<FrameMatrix> states);

  // Divides the frames [begin, end) along their principal axis (eqs. 3-5): those left of the
  // minimum-error threshold come to stand before the others; frames that project alike are divided
  // by their numbers. Returns how many are on the left; 0, and changes nothing, if either side
  // would have fewer than min_frames. Else `plane` says where. `centred` is scratch. The order
  // within a side is not that of the frames, but the same on any number of threads.
  int Divide(std::int32_t begin, std::int32_t end, int min_frames, std::vector<float>& centred,
             const ParallelFor& parallel, SplitPlane& plane);

  // Of frames [begin, end) that Divide has just left undivided: moves those of the smaller side of
  // the threshold to one end, and narrows the range to the others. False, and changes nothing, if
  // there is no threshold.
  bool SetAside(std::int32_t& begin, std::int32_t& end, const ParallelFor& parallel);

  // Puts the rows of the states back into their own order, that of the frames.
  void Restore(const ParallelFor& parallel);

  // The frame at each place.
  std::vector<std::int32_t>& order() { return order_; }
  auto row(std::int32_t place) const { return rows_.row(place); }

 private:
  void Project(std::int32_t begin, std::int32_t end, const NodeAxis& node,
               const ParallelFor& parallel);
  void MoveLeft(std::int32_t begin, std::int32_t end, int left, const ParallelFor& parallel);

  Eigen::Map<FrameMatrix> rows_;
  std::vector<std::int32_t> order_;
  // Of each place, valid from one Divide of it to the next.
  std::vector<double> projections_;
  std::vector<double> sorted_;
  std::vector<double> scratch_;
  std::vector<std::int32_t> misplaced_;
};

// Sorting of many numbers that are spread about evenly, as projections of states are: faster than
// comparing. Safe to call from any thread; uses only the threads lent to it.

// Sorts finite values, ascending, the same on any number of threads. `scratch` is as long as they
// are. They are dealt into buckets by value, which are then sorted: O(n) where they are spread
// about evenly, O(n log n) at worst.
void SortValues(std::span<double> values, std::span<double> scratch, const ParallelFor& parallel);

}  // namespace motiondb::core
