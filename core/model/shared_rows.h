// A shared matrix that grows at its end: an extended model has the rows of its base in the same
// memory. Existing rows never change, so views may be read from any thread while WithMore appends.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "core/motion/execution.h"
#include "core/motion/matrix.h"
#include "core/tree/feature_scale.h"

namespace motiondb::core {

// Returns the capacity to reserve after `rows` rows. A model is rebuilt before it adds more frames
// than this (ModelDrift). Unused capacity needs address space but no memory.
constexpr Eigen::Index RoomToGrow(Eigen::Index rows) { return rows / 8; }

class SharedRows {
 public:
  SharedRows() = default;
  explicit SharedRows(FrameMatrix rows) : SharedRows(std::move(rows), 0) {}
  // The last `room` rows are unused capacity.
  SharedRows(FrameMatrix rows, Eigen::Index room)
      : count_(rows.rows() - room), memory_(std::make_shared<Memory>(std::move(rows), count_)) {}

  Eigen::Index rows() const { return count_; }
  Eigen::Index cols() const { return memory_ == nullptr ? 0 : memory_->rows.cols(); }
  Eigen::Index size() const { return rows() * cols(); }
  auto row(Eigen::Index r) const { return std::as_const(memory_->rows).row(r); }
  auto middleRows(Eigen::Index first, Eigen::Index count) const {
    return view().middleRows(first, count);
  }
  // Valid while this object or an extension of it exists.
  Eigen::Map<const FrameMatrix> view() const {
    return {memory_ == nullptr ? nullptr : memory_->rows.data(), rows(), cols()};
  }

  // Returns these rows and `more` (same number of columns). Appends in place if enough capacity
  // is unused; otherwise copies all rows with new capacity. Amortized O(added rows).
  SharedRows WithMore(FrameMatrix more) const {
    if (memory_ == nullptr) return SharedRows(std::move(more));
    SharedRows grown = *this;
    grown.count_ = count_ + more.rows();
    Eigen::Index used = count_;
    if (grown.count_ > memory_->rows.rows() ||
        !memory_->used.compare_exchange_strong(used, grown.count_)) {
      FrameMatrix copy(grown.count_ + RoomToGrow(grown.count_), more.cols());
      copy.topRows(count_) = view();
      grown.memory_ = std::make_shared<Memory>(std::move(copy), grown.count_);
    }
    grown.memory_->rows.middleRows(count_, more.rows()) = more;
    return grown;
  }

 private:
  struct Memory {
    Memory(FrameMatrix all, Eigen::Index used_rows) : rows(std::move(all)), used(used_rows) {}
    FrameMatrix rows;  // rows from `used` on are unused capacity
    std::atomic<Eigen::Index> used;
  };
  Eigen::Index count_ = 0;
  std::shared_ptr<Memory> memory_;
};

// Scales states (rows x dimensions) in place.
inline void ScaleInPlace(const FeatureScale& scale, Eigen::Map<FrameMatrix> states,
                         const ParallelFor& parallel) {
  constexpr int kBlockRows = 1024;
  const auto rows = static_cast<int>(states.rows());
  parallel((rows + kBlockRows - 1) / kBlockRows, [&](int block) {
    const int first = block * kBlockRows;
    states.middleRows(first, std::min(kBlockRows, rows - first)).array().rowwise() /=
        scale.divisor.array();
  });
}

// Scales `states` (rows x dimensions) except for the last `room` rows, which are unused capacity.
inline SharedRows ScaleRows(const FeatureScale& scale, FrameMatrix states, Eigen::Index room,
                            const ParallelFor& parallel) {
  ScaleInPlace(scale, {states.data(), states.rows() - room, states.cols()}, parallel);
  return SharedRows(std::move(states), room);
}

}  // namespace motiondb::core
