#include "core/model/relabel.h"

#include <utility>

#include "core/motion/error.h"

namespace motiondb::core {

absl::StatusOr<Model> WithLabels(const Model& base, std::vector<ClipLabels> labels) {
  Model relabelled = base;
  MOTIONDB_RETURN_IF_ERROR(relabelled.set_labels(std::move(labels)));
  return relabelled;
}

}  // namespace motiondb::core
