// Tells the service manager how the server stands, by the protocol of sd_notify(3): a datagram to
// the socket that NOTIFY_SOCKET names. A few lines, so that no library of systemd's is needed where
// there is no systemd.
#pragma once

#include <string>

namespace motiondb::server {

// `state` is lines of NAME=VALUE, as "READY=1". Does nothing where nobody listens. Thread-safe.
void NotifyServiceManager(const std::string& state);

}  // namespace motiondb::server
