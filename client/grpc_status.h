// How a failed call becomes an absl::Status. Pure functions, safe on any thread.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "absl/status/status.h"

namespace motiondb::client {

// The same canonical code and message. The field violations of `grpc-status-details-bin` are
// appended as "field: description" where the message does not say them already, and attached as a
// payload under kBadRequestTypeUrl.
//
// The call's id and when to try again are attached under kRequestInfoTypeUrl and kRetryInfoTypeUrl.
// Unless the error is about what was asked for (INVALID_ARGUMENT, NOT_FOUND, ALREADY_EXISTS,
// FAILED_PRECONDITION, OUT_OF_RANGE), the message names the id, "(request ...)", for a person to
// look up in the server's log.
absl::Status FromGrpc(const grpc::Status& status);

// The same with a call's id attached.
absl::Status WithRequestId(absl::Status status, const std::string& request_id);

// The same code and payloads with another message.
absl::Status WithMessage(const absl::Status& status, const std::string& message);

}  // namespace motiondb::client
