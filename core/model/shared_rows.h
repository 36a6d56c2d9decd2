// A matrix that grows at its end and is shared: the rows of a model are the first rows of the one
// that extends it, in the same memory. What is there never changes, so views may be read from any
// thread while WithMore adds rows behind them.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include "core/motion/matrix.h"
#include "core/tree/feature_scale.h"
#include "core/tree/parallel.h"

namespace motiondb::core {

// Rows that so many keep room for behind them. A model is built again before as many frames were
// added to it (ModelDrift). They cost addresses, and no memory before they are taken.
constexpr Eigen::Index RoomToGrow(Eigen::Index rows) { return rows / 8; }

class SharedRows {
 public:
  SharedRows() = default;
  explicit SharedRows(FrameMatrix rows) : SharedRows(std::move(rows), 0) {}
  // The last `room` rows are room for more.
  SharedRows(FrameMatrix rows, Eigen::Index room)
      : count_(rows.rows() - room), memory_(std::make_shared<Memory>(std::move(rows), count_)) {}

  Eigen::Index rows() const { return count_; }
  Eigen::Index cols() const { return memory_ == nullptr ? 0 : memory_->rows.cols(); }
  Eigen::Index size() const { return rows() * cols(); }
  auto row(Eigen::Index r) const { return std::as_const(memory_->rows).row(r); }
  auto middleRows(Eigen::Index first, Eigen::Index count) const {
    return view().middleRows(first, count);
  }
  // Valid as long as this or what extends it lives.
  Eigen::Map<const FrameMatrix> view() const {
    return {memory_ == nullptr ? nullptr : memory_->rows.data(), rows(), cols()};
  }

  // These rows and `more` (of as many columns). Takes over `more` where there are no rows yet,
  // takes room behind these where nobody else took it, else copies them with RoomToGrow, so that
  // adding costs what is added in the long run.
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
    Memory(FrameMatrix all, Eigen::Index taken) : rows(std::move(all)), used(taken) {}
    FrameMatrix rows;  // those behind `used` are room
    std::atomic<Eigen::Index> used;
  };
  Eigen::Index count_ = 0;
  std::shared_ptr<Memory> memory_;
};

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
