// One connection of a client, as the listener sees it. The protocols implement it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "server/listen/byte_stream.h"

namespace motiondb::server {

// Stays on the thread of its io_context, except where noted.
class ClientConnection {
 public:
  using Clock = std::chrono::steady_clock;

  virtual ~ClientConnection() = default;

  virtual void Start() = 0;
  // Checks all time limits. Called about once a second.
  virtual void Tick(Clock::time_point now) = 0;
  // Asks the client to make no more calls on this connection. Those that it makes are served.
  virtual void BeginDrain() = 0;
  // Begins no more calls; closes after the last one.
  virtual void Drain() = 0;
  virtual void Close() = 0;
  // Runs `work` on the connection's thread, then sends pending output. Callable from any thread.
  virtual void Post(std::function<void()> work) = 0;

  // Number of open calls; callable from any thread.
  virtual int calls() const = 0;
  Clock::time_point began() const { return began_; }

 private:
  const Clock::time_point began_ = Clock::now();
};

// An accepted client, from which a protocol makes its connection.
struct AcceptedClient {
  // Called on the connection's thread when it has ended. `reason`: why the server closed it; empty
  // if the client closed it.
  using OnClosed =
      std::function<void(const std::shared_ptr<ClientConnection>&, const std::string& reason)>;

  boost::asio::io_context& context;
  ByteStream bytes;
  std::string peer;  // in gRPC's format, "ipv4:127.0.0.1:50000"
  OnClosed on_closed;
};

// Called on all threads of the listener.
using MakeConnection = std::function<std::shared_ptr<ClientConnection>(AcceptedClient)>;

}  // namespace motiondb::server
