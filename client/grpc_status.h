// How a failed call becomes an absl::Status. Pure functions, safe on any thread.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"

namespace motiondb::client {

// The same canonical code and message. The field violations of `grpc-status-details-bin` are
// appended as "field: description" where the message does not say them already, and attached as a
// payload under kBadRequestTypeUrl.
absl::Status FromGrpc(const grpc::Status& status);

}  // namespace motiondb::client
