#include "server/translate/retry_info.h"

#include <string>

#include "absl/strings/cord.h"
#include "motiondb/v1/error.pb.h"

namespace motiondb::server {

absl::Status RetryLater(std::chrono::milliseconds delay, std::string_view message) {
  v1::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(delay.count() / 1000);
  retry.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
  absl::Status status = absl::ResourceExhaustedError(std::string(message));
  status.SetPayload(kRetryInfoUrl, absl::Cord(retry.SerializeAsString()));
  return status;
}

}  // namespace motiondb::server
