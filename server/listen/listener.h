// Accepts connections, as plain text or TLS, and runs them on a few threads. A protocol (HTTP/2,
// HTTP/1.1) makes the connection of each client.
//
// The number of connections is limited, in total and for an address. At a limit, a new connection
// replaces the oldest one without a call of its address, or, in total, of the address with the most
// connections. Some descriptors are left for other uses.
// Thread-safe; owns its sockets and threads.
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/listen/client_connection.h"
#include "server/listen/connection_meter.h"
#include "server/security/attempt_limit.h"
#include "server/security/tls.h"
#include "storage/mutex.h"

namespace motiondb::server {

// Raises the soft limit of open files to the hard limit, at most 65,536. Call first in main.
void RaiseDescriptorLimit();

struct ListenerOptions {
  const Tls* tls = nullptr;  // null: plain text
  TlsProtocol protocol = TlsProtocol::kHttp2;
  unsigned threads = 4;  // at most, and at most one for each core
  std::size_t connections = std::numeric_limits<std::size_t>::max();
  std::size_t connections_per_address = 1024;
};

class Listener {
 public:
  // Listens at each address of HOST:PORT; port 0 selects a free port. `make` and what it uses live
  // as long as the connections. The Tls of the options and `meter` must outlive the listener.
  // Errors: those of ListenOn.
  static absl::StatusOr<std::unique_ptr<Listener>> Start(const std::string& listen,
                                                         const ListenerOptions& options,
                                                         MakeConnection make,
                                                         ConnectionMeter& meter);
  // Waits until all connections are released. Their calls must have ended.
  ~Listener();

  int port() const;
  // Stops accepting connections, and asks clients to use other ones for new calls. Returns when no
  // more connection is accepted.
  void BeginDrain();
  // Stops accepting connections and drains the others, then returns. Connections that are
  // still open after `grace` are closed.
  void Close(std::chrono::milliseconds grace);

 private:
  using Acceptor = boost::asio::ip::tcp::acceptor;
  using Connections = std::multiset<std::shared_ptr<ClientConnection>>;
  // A thread and its connections.
  struct Loop {
    boost::asio::io_context context{1};
    // Keeps the thread until Close has run on it: a tick that expires meanwhile is not renewed.
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work{
        context.get_executor()};
    boost::asio::steady_timer ticks{context};
    std::set<std::shared_ptr<ClientConnection>> connections;
    std::thread thread;
  };

  Listener(const ListenerOptions& options, MakeConnection make, ConnectionMeter& meter);
  static std::vector<std::unique_ptr<Loop>> MakeLoops(unsigned threads);
  absl::Status Listen(const std::string& listen);
  void Await(Acceptor& acceptor);
  void Accept(Acceptor& acceptor);
  void AwaitLoops(Acceptor& acceptor);
  bool AcceptWaiting(Acceptor& acceptor);
  void Admit(int descriptor, const boost::asio::ip::tcp::endpoint& client);
  void Begin(Loop& loop, int descriptor, const boost::asio::ip::tcp::endpoint& client);
  bool MakeRoom(const std::string& address);
  bool CloseOne(const std::string* address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Forget(Loop& loop, const std::shared_ptr<ClientConnection>& connection,
              const std::string& address, const std::string& reason);
  void Tick(Loop& loop);
  void StopAccepting();

  const ListenerOptions options_;
  const MakeConnection make_;
  ConnectionMeter& meter_;
  const int max_descriptors_;
  std::vector<std::unique_ptr<Loop>> loops_;
  std::vector<Acceptor> acceptors_;         // on the first loop
  boost::asio::steady_timer accept_retry_;  // used if no connection can be accepted
  std::atomic<bool> draining_ = false;      // no more connections are accepted
  std::atomic<bool> closing_ = false;
  std::size_t next_loop_ = 0;
  AttemptLimit warnings_;
  storage::Mutex mutex_;
  // By client address. Connections that are being set up are null.
  std::map<std::string, Connections> by_address_ ABSL_GUARDED_BY(mutex_);
  std::size_t count_ ABSL_GUARDED_BY(mutex_) = 0;  // of all addresses
};

}  // namespace motiondb::server
