// The HTTP port: the Connect protocol (connectrpc.com) over HTTP/1.1 for every RPC of motiondb.v1
// that does not stream requests. It passes each request to the gRPC server of this process.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/http2/call_bridge.h"
#include "server/listen/connection_meter.h"
#include "server/security/tls.h"

namespace motiondb::server {

class Listener;
class ThreadPool;
class ConnectHandler;

// Thread-safe; owns its sockets and threads.
class Gateway {
 public:
  // Listens at HOST:PORT; port 0 selects a free port. `tls`: null for plain text. `authenticates`:
  // calls need a token. `tls` and `meter` must outlive the gateway. Errors: those of ListenOn.
  static absl::StatusOr<std::unique_ptr<Gateway>> Start(const std::string& listen, const Tls* tls,
                                                        bool authenticates,
                                                        std::shared_ptr<CallBridge> bridge,
                                                        ConnectionMeter& meter);
  // Waits until gRPC has released its calls. They must have ended.
  ~Gateway();

  // HOST:PORT for clients.
  const std::string& address() const { return address_; }
  // Stops accepting connections and requests, then returns. Connections that are still open after
  // `grace` are closed.
  void Close(std::chrono::milliseconds grace);

 private:
  Gateway();

  std::unique_ptr<ThreadPool> converters_;  // the members below use it
  std::unique_ptr<ConnectHandler> handler_;
  std::unique_ptr<Listener> listener_;
  std::string address_;
};

}  // namespace motiondb::server
