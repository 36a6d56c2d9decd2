// Which option to change where the server was not reached.
#pragma once

#include <string>

#include "client/cli/command.h"

namespace motiondb::client {

// The same error, and after it what to do; errors that are not about connecting stay as they are.
absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global);

}  // namespace motiondb::client
