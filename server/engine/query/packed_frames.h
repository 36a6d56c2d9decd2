// Frames as packed in a request. Sizes are checked before memory is allocated. Errors are
// INVALID_ARGUMENT naming the field and, if possible, the frame.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/matrix.h"

namespace motiondb::server {

struct PackedFrames {
  int frame_count = 0;
  std::string_view values;  // float32, little-endian, row-major
};

// Returns the matrix (frames x columns) in field `name` of the message `field`.
absl::StatusOr<core::FrameMatrix> Unpack(std::string_view field, std::string_view name,
                                         const PackedFrames& packed, int columns);

absl::Status CheckFinite(std::string_view field, const core::FrameMatrix& frames);
// Each marker (frames x 3 names) must be finite, or NaN in all three coordinates (missing).
absl::Status CheckMarkers(std::string_view field, const std::vector<std::string>& names,
                          const core::FrameMatrix& positions_m);
// Marker names must be unique and not empty.
absl::Status CheckUnique(std::string_view field, const std::vector<std::string>& names);

}  // namespace motiondb::server
