// Which fields of a request the server found wrong. Functions here are pure, safe on any thread.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace motiondb::client {

// Under this type URL a failed call's absl::Status carries a google.rpc.BadRequest as payload.
inline constexpr absl::string_view kBadRequestTypeUrl = "type.googleapis.com/google.rpc.BadRequest";

// One field that was wrong.
struct FieldViolation {
  // Path of the field in the request, e.g. `observation.markers.frame_rate_hz`.
  std::string field;
  // What was expected.
  std::string description;
};

// The fields that made a call fail, in the server's order; empty where it named none.
std::vector<FieldViolation> FieldViolations(const absl::Status& status);

}  // namespace motiondb::client
