#include "server/observability/call_watch.h"

#include "server/observability/call_log.h"

namespace motiondb::server {

CallWatch::CallWatch(Monitor& monitor, std::string_view method, CallKind kind)
    : monitor_(monitor), method_(monitor.calls().Find(method)), kind_(kind) {
  monitor_.calls().Begin(kind_);
}

CallWatch::~CallWatch() {
  if (!ended_) Count(absl::StatusCode::kCancelled);
}

void CallWatch::End(absl::StatusCode code, const std::string& message,
                    const std::string& request_id, const std::string& peer) {
  const double seconds = Count(code);
  LogCall({.method = method_.name(),
           .request_id = request_id,
           .peer = peer,
           .kind = kind_,
           .code = code,
           .message = message,
           .seconds = seconds},
          monitor_.slow_call());
}

double CallWatch::Count(absl::StatusCode code) {
  ended_ = true;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began_;
  monitor_.calls().End(method_, kind_, code, took.count());
  return took.count();
}

}  // namespace motiondb::server
