// Labels and subjects of stored clips, as models have them.
#pragma once

#include <optional>
#include <vector>

#include "core/model/model.h"
#include "server/filter/catalog.h"

namespace motiondb::server {

// Returns the stored labels and subjects of the model's clips, or nullopt if the model has them. A
// clip that is no longer stored keeps its own. O(clips + segments).
std::optional<std::vector<core::ClipLabels>> StoredLabels(const core::Model& model,
                                                          const Catalog& catalog);

}  // namespace motiondb::server
