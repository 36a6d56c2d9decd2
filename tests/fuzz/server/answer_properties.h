// The contract of every answer to a query.
#pragma once

#include <google/protobuf/message.h>

#include "absl/status/status.h"

namespace motiondb::tests {

// All numbers are finite, except log probabilities, which may be -infinity.
void CheckAllFinite(const google::protobuf::Message& answer);

// The error is the client's fault or a limit, and has a message.
void CheckRefusalContract(const absl::Status& status);

}  // namespace motiondb::tests
