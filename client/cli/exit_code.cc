#include "client/cli/exit_code.h"

#include <string>

#include "absl/strings/cord.h"

namespace motiondb::client {
namespace {

constexpr absl::string_view kExitCodeUrl = "motiondb/exit-code";

}  // namespace

absl::Status WithExitCode(absl::Status status, int code) {
  status.SetPayload(kExitCodeUrl, absl::Cord(std::to_string(code)));
  return status;
}

int ExitCodeOf(const absl::Status& status) {
  if (status.ok()) return 0;
  const auto payload = status.GetPayload(kExitCodeUrl);
  return payload.has_value() ? std::stoi(std::string(*payload)) : kFailed;
}

}  // namespace motiondb::client
