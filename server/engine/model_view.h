// Geometry of a model for pictures. Computed on the first use, then shared by all calls; freed with
// the model. Thread-safe.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/planning/contacts.h"
#include "core/tree/parallel.h"
#include "core/view/bones.h"
#include "core/view/state_axes.h"
#include "server/engine/representation.h"
#include "storage/cancellable_lock.h"
#include "storage/mutex.h"

namespace motiondb::server {

// The markers of a model as a figure.
struct ModelFigure {
  std::vector<core::BoneEnds> bones;
  core::Feet feet;
};

class ModelView {
 public:
  // Returns the principal axes of the model's states: 12 bytes for each frame. The first caller
  // computes them, on the threads of `parallel` (seconds for 1,000,000 frames); others wait.
  // CANCELLED; the next caller then computes. RESOURCE_EXHAUSTED. REQUIRES, also for Figure: every
  // call is for the same states.
  absl::StatusOr<std::shared_ptr<const core::StateAxes>> Axes(const core::Model& model,
                                                              const core::ParallelFor& parallel,
                                                              const WorkOptions& terms);
  // Light work.
  std::shared_ptr<const ModelFigure> Figure(const core::Model& model);

 private:
  storage::CancellableMutex computing_;  // held while the axes are computed
  storage::Mutex mutex_;
  std::shared_ptr<const core::StateAxes> axes_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const ModelFigure> figure_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
