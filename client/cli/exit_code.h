// The program's exit code where a command failed, for those that scripts tell apart.
#pragma once

#include "absl/status/status.h"

namespace motiondb::client {

inline constexpr int kFailed = 1;
inline constexpr int kWrongUsage = 2;
inline constexpr int kUnreachable = 3;  // a plan: the goal cannot be reached

// The same error, with which the program is to exit by `code`.
absl::Status WithExitCode(absl::Status status, int code);

// 0 where all is well; kFailed where the error does not say.
int ExitCodeOf(const absl::Status& status);

}  // namespace motiondb::client
