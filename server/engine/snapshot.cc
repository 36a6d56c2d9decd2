#include "server/engine/snapshot.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

// Memory of a call that finds the axes: sums of products of pairs of dimensions. The positions of
// the frames stay with the model, whose memory they increase by about 1 %: no limit of a call
// applies.
std::int64_t BytesToFindAxes(const core::Model& model) {
  const std::int64_t dimensions = model.states().cols();
  return 48 * dimensions * dimensions;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const core::StateAxes>> ModelView::Axes(
    const core::Model& model, const core::ParallelFor& parallel, const WorkOptions& terms) {
  const auto known = [this] {
    const storage::MutexLock lock(mutex_);
    return axes_;
  };
  if (auto axes = known(); axes != nullptr) return axes;
  MOTIONDB_ASSIGN_OR_RETURN(const auto computing, computing_.Lock(terms.cancelled));
  if (auto axes = known(); axes != nullptr) return axes;
  MOTIONDB_RETURN_IF_ERROR(terms.Reserve(BytesToFindAxes(model)));
  MOTIONDB_ASSIGN_OR_RETURN(core::StateAxes found,
                            core::FindStateAxes(model.states(), parallel, terms.cancelled));
  auto axes = std::make_shared<const core::StateAxes>(std::move(found));
  const storage::MutexLock lock(mutex_);
  axes_ = axes;
  return axes;
}

std::shared_ptr<const ModelFigure> ModelView::Figure(const core::Model& model) {
  {
    const storage::MutexLock lock(mutex_);
    if (figure_ != nullptr) return figure_;
  }
  // Two first callers may both compute it; the results are equal.
  auto figure = std::make_shared<const ModelFigure>(
      ModelFigure{core::MarkerBones(model), core::FindFeet(model)});
  const storage::MutexLock lock(mutex_);
  figure_ = figure;
  return figure;
}

}  // namespace motiondb::server
