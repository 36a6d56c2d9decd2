// Obstacles of a request -> core's. Safe to call from any thread.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/planning/obstacles.h"

namespace motiondb::v1 {
class Obstacles;
}

namespace motiondb::server {

// `field` is the message's own name in the request, and leads the names of fields in errors.
// INVALID_ARGUMENT for more than 1000 obstacles or 10,000 corners, for what is missing or not
// finite, a disc without a radius, and a polygon that has no inside.
absl::StatusOr<core::Obstacles> ObstaclesFrom(std::string_view field, const v1::Obstacles& message);

}  // namespace motiondb::server
