// Packed frames of a request, checked before memory is taken for them. Errors are INVALID_ARGUMENT
// that names the field, and the frame where there is one. Safe to call from any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/motion.h"

namespace motiondb::server {

struct FrameShape {
  int frame_count = 0;
  int column_count = 0;
};

// Unpacks the field `name` of the message `field`, whose frame_count the shape has.
absl::StatusOr<core::FrameMatrix> FramesFrom(std::string_view field, std::string_view name,
                                             const FrameShape& shape, const std::string& bytes);

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames);
// Each marker (frames x 3 names) is finite, or NaN in all three: missing.
absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions_m);
absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names);

}  // namespace motiondb::server
