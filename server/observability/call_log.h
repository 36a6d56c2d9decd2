// What the log says of calls: those that failed by the server's fault as errors, slow ones as
// warnings, all others on the level debug. Of what a call carried it says nothing, neither metadata
// nor messages. Thread-safe.
#pragma once

#include <chrono>
#include <string>

#include "absl/status/status.h"
#include "server/observability/call_meter.h"

namespace motiondb::server {

// A call that has ended.
struct EndedCall {
  std::string method;      // "QueryService.Recognize"
  std::string request_id;  // as the client sent it, or the server made it
  std::string peer;        // address of the client
  CallKind kind = CallKind::kWork;
  absl::StatusCode code = absl::StatusCode::kOk;
  std::string message;  // of the status
  double seconds = 0;
};

// Only work can be slow: how long other calls last is up to somebody else. 0: none is slow.
void LogCall(const EndedCall& call, std::chrono::duration<double> slow);

}  // namespace motiondb::server
