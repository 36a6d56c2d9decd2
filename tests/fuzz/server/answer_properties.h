// What every answer to a query is promised to be. Safe to call from any thread.
#pragma once

#include <google/protobuf/message.h>

#include "absl/status/status.h"

namespace motiondb::tests {

// All numbers are finite, but for log probabilities, which may be -infinity.
void HoldsFinite(const google::protobuf::Message& answer);

// An error that is the client's own, or one that a limit set, with words.
void HoldsRefusal(const absl::Status& status);

}  // namespace motiondb::tests
