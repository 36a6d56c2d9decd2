// Frames as a request packs them: checked before memory is taken for them. Errors are
// INVALID_ARGUMENT that names the field, and the frame where there is one. Safe to call from any
// thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"

namespace motiondb::server {

struct PackedFrames {
  int frame_count = 0;
  std::string_view values;  // float32, little-endian, frame by frame
};

// Frames x columns: the field `name` of the message `field`, which has `frame_count` beside it.
absl::StatusOr<core::FrameMatrix> Unpack(std::string_view field, std::string_view name,
                                         const PackedFrames& packed, int columns);

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames);
// Each marker (frames x 3 names) is finite, or NaN in all three: missing.
absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions_m);
// Names of markers: unique, and none empty.
absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names);

}  // namespace motiondb::server
