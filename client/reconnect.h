// When a stream that has ended is opened again.
#pragma once

#include <chrono>
#include <optional>

#include "absl/status/status.h"

namespace motiondb::client {

// Delays between attempts to open a stream again. Not thread-safe.
class ReconnectDelays {
 public:
  // `address_count`: addresses of the client. The first attempts are made without a delay, so that
  // each other server is tried; if there is none, after 0.2 s. Later delays double, up to 10 s.
  explicit ReconnectDelays(int address_count);

  // Returns the delay of the next attempt, at least the retry delay in `error`. nullopt if `error`
  // is not UNAVAILABLE and has no retry delay: another attempt would not fix it.
  std::optional<std::chrono::milliseconds> Next(const absl::Status& error);

  // The stream works: the next attempt is a first one.
  void Reset();

 private:
  const int other_addresses_;
  int attempts_ = 0;
};

}  // namespace motiondb::client
