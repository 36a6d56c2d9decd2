#include "server/translate/retry_info.h"

#include "absl/strings/cord.h"
#include "motiondb/v1/error.pb.h"

namespace motiondb::server {

absl::Status RetryAfter(absl::Status status, std::chrono::milliseconds delay) {
  v1::RetryInfo info;
  info.mutable_retry_delay()->set_seconds(delay.count() / 1000);
  info.mutable_retry_delay()->set_nanos(static_cast<int>(delay.count() % 1000) * 1'000'000);
  status.SetPayload("type.googleapis.com/google.rpc.RetryInfo",
                    absl::Cord(info.SerializeAsString()));
  return status;
}

}  // namespace motiondb::server
