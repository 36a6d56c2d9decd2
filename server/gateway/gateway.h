// The HTTP port: the Connect protocol (connectrpc.com) over HTTP/1.1 for every RPC of motiondb.v1
// that does not stream requests, the web page, and the login of its user. It passes each request of
// an RPC to the gRPC server of this process.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/http2/call_bridge.h"
#include "server/security/tls.h"

namespace motiondb::server {

class Listener;
class ThreadPool;
class ConnectHandler;
struct ServiceContext;

struct GatewayOptions {
  std::string listen;        // HOST:PORT; port 0 selects a free port
  const Tls* tls = nullptr;  // null: plain text
  std::string web_root;      // folder of the web page; empty: InstalledPageFolder()
};

// Thread-safe; owns its sockets and threads.
class Gateway {
 public:
  // Reads the web page and listens. If the page is not installed, a line is logged, and requests
  // for it get 404. `tls` and `host` must outlive the gateway. Errors: those of ListenOn;
  // INVALID_ARGUMENT if the page cannot be read.
  static absl::StatusOr<std::unique_ptr<Gateway>> Start(const GatewayOptions& options,
                                                        ServiceContext& host,
                                                        std::shared_ptr<CallBridge> bridge);
  // Waits until gRPC has released its calls. They must have ended.
  ~Gateway();

  // HOST:PORT for clients.
  const std::string& address() const { return address_; }
  // See Listener::BeginDrain.
  void BeginDrain();
  // Stops accepting connections and requests, then returns. Connections that are still open after
  // `grace` are closed.
  void Close(std::chrono::milliseconds grace);

 private:
  Gateway();

  // The members below use the threads.
  std::unique_ptr<ThreadPool> converters_;
  std::unique_ptr<ThreadPool> sessions_;
  std::unique_ptr<ConnectHandler> handler_;
  std::unique_ptr<Listener> listener_;
  std::string address_;
};

}  // namespace motiondb::server
