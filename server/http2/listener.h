// Accepts connections and serves HTTP/2 on them, as plain text or TLS, for the gRPC server of this
// process. gRPC 1.51 does not bound the memory of a connection before its call begins. So gRPC gets
// only complete calls and messages.
//
// A client address may have kMaxPerAddress connections (listener.cc). At the limit the oldest
// connection without a call is closed for a new one. Some descriptors are left for other uses.
// Thread-safe; owns its sockets and threads.
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/http2/call_stream.h"
#include "server/http2/connection.h"
#include "server/observability/call_meter.h"
#include "server/security/attempt_limit.h"
#include "storage/mutex.h"

namespace motiondb::server {

class Tls;

// Raises the soft limit of open files to the hard limit, at most 65,536. Call first in main.
void RaiseDescriptorLimit();

class Listener {
 public:
  // Listens at each address of HOST:PORT; port 0 selects a free port. `tls`: null for plain text.
  // `tls` and `meter` must outlive the listener. Errors: those of ListenOn.
  static absl::StatusOr<std::unique_ptr<Listener>> Start(const std::string& listen, const Tls* tls,
                                                         std::unique_ptr<CallBridge> bridge,
                                                         ConnectionMeter& meter);
  // Waits until gRPC has released its calls. They must have ended.
  ~Listener();

  int port() const;
  // Stops accepting connections and calls and sends GOAWAY, then returns. Connections that are
  // still open after `grace` are closed.
  void Close(std::chrono::milliseconds grace);

 private:
  using Acceptor = boost::asio::ip::tcp::acceptor;
  // A thread and its connections.
  struct Loop {
    boost::asio::io_context context{1};
    // Keeps the thread until Close has run on it: a tick that expires meanwhile is not renewed.
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work{
        context.get_executor()};
    boost::asio::steady_timer ticks{context};
    std::set<std::shared_ptr<Connection>> connections;
    std::thread thread;
  };

  Listener(const Tls* tls, std::unique_ptr<CallBridge> bridge, ConnectionMeter& meter);
  static std::vector<std::unique_ptr<Loop>> MakeLoops();
  absl::Status Listen(const std::string& listen);
  void Await(Acceptor& acceptor);
  void Accept(Acceptor& acceptor);
  bool AcceptWaiting(Acceptor& acceptor);
  void Admit(int descriptor, const boost::asio::ip::tcp::endpoint& client);
  void Begin(Loop& loop, int descriptor, const boost::asio::ip::tcp::endpoint& client);
  bool MakeRoom(const std::string& address);
  void Forget(Loop& loop, const std::shared_ptr<Connection>& connection, const std::string& address,
              const std::string& reason);
  void Tick(Loop& loop);

  const Tls* const tls_;
  const std::unique_ptr<CallBridge> bridge_;
  ConnectionMeter& meter_;
  const int max_descriptors_;
  std::vector<std::unique_ptr<Loop>> loops_;
  std::vector<Acceptor> acceptors_;         // on the first loop
  boost::asio::steady_timer accept_retry_;  // used if no connection can be accepted
  std::atomic<bool> closing_ = false;
  std::size_t next_loop_ = 0;
  AttemptLimit warnings_;
  storage::Mutex mutex_;
  // By client address. Connections that are being set up are null.
  std::map<std::string, std::multiset<std::shared_ptr<Connection>>> by_address_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
