// The wrong fields of a request, as reported by the server.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace motiondb::client {

// Type URL of the payload google.rpc.BadRequest in the absl::Status of a failed call.
inline constexpr absl::string_view kBadRequestTypeUrl = "type.googleapis.com/google.rpc.BadRequest";

struct FieldViolation {
  // Path of the field in the request, e.g. `observation.markers.frame_rate_hz`.
  std::string field;
  // What was expected.
  std::string description;
};

// Returns the wrong fields of a failed call in the server's order; empty if there are none.
std::vector<FieldViolation> FieldViolations(const absl::Status& status);

}  // namespace motiondb::client
