// Takes connections and serves HTTP/2 on them, in plain text or TLS, for the gRPC server of this
// process. gRPC 1.51 has no bound on what a connection may hold before its call begins, so no
// client's bytes reach it but as the messages of a call.
//
// A client address has at most so many connections (kPerAddress in listener.cc); at the limit the
// oldest one without a call makes room. Some descriptors are left for everything else.
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

// Lets the process open as many files as it may, up to those of the most connections that are
// taken. For whoever starts it, before anything else.
void RaiseDescriptorLimit();

class Listener {
 public:
  // Listens at HOST:PORT, at each address that the host has; port 0 is one that is free. `tls` is
  // null for plain text, and outlives the listener as `meter` does. The codes of ListenOn.
  static absl::StatusOr<std::unique_ptr<Listener>> Start(const std::string& listen, const Tls* tls,
                                                         std::unique_ptr<CallBridge> bridge,
                                                         ConnectionMeter& meter);
  // Waits for the calls that gRPC still has: they must have been ended.
  ~Listener();

  int port() const;
  // Takes no connections and begins no calls any more once it has returned, tells clients to go,
  // and cuts those that have not after `grace`.
  void Close(std::chrono::milliseconds grace);

 private:
  using Acceptor = boost::asio::ip::tcp::acceptor;
  // A thread and the connections that live on it.
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
  const int most_descriptors_;
  std::vector<std::unique_ptr<Loop>> loops_;
  std::vector<Acceptor> acceptors_;  // on the first loop
  boost::asio::steady_timer rest_;   // of them, while no connection can be taken
  std::atomic<bool> closing_ = false;
  std::size_t next_loop_ = 0;
  AttemptLimit warnings_;
  storage::Mutex mutex_;
  // By address; connections that are being set up are null.
  std::map<std::string, std::multiset<std::shared_ptr<Connection>>> by_address_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::server
