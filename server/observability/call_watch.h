// One call as the monitor sees it: counted from its first moment to its last, then timed and
// logged. Used by one thread at a time.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/observability/monitor.h"

namespace motiondb::server {

class CallWatch {
 public:
  // The monitor must outlive the watch.
  CallWatch(Monitor& monitor, std::string_view method, CallKind kind);
  // A call that had no end is counted as CANCELLED: its client went away.
  ~CallWatch();
  CallWatch(const CallWatch&) = delete;
  CallWatch& operator=(const CallWatch&) = delete;

  // Once. `message` is the status's, for the log.
  void End(absl::StatusCode code, const std::string& message, const std::string& request_id,
           const std::string& peer);

 private:
  double Count(absl::StatusCode code);

  Monitor& monitor_;
  CallMeter::Method& method_;
  const CallKind kind_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  bool ended_ = false;
};

}  // namespace motiondb::server
