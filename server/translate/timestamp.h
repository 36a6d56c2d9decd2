// Microseconds since the Unix epoch -> google.protobuf.Timestamp.
#pragma once

#include <google/protobuf/timestamp.pb.h>

#include <cstdint>

namespace motiondb::server {

inline void SetTimestamp(std::int64_t time_us, google::protobuf::Timestamp& timestamp) {
  timestamp.set_seconds(time_us / 1'000'000);
  timestamp.set_nanos(static_cast<std::int32_t>(time_us % 1'000'000 * 1000));
}

}  // namespace motiondb::server
