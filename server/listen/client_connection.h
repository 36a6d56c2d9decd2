// One connection of a client: its socket, and the interface that the protocols implement.
#pragma once

#include <openssl/ssl.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "server/security/tls.h"

namespace motiondb::server {

// A connected non-blocking TCP socket, with or without TLS. Not thread-safe.
class ByteStream {
 public:
  // Outcome of a read or a write.
  enum class Outcome {
    kDone,        // transferred `bytes`, at least 1
    kWantsRead,   // transferred nothing: retry when the socket is readable
    kWantsWrite,  // transferred nothing: retry when the socket is writable
    kClosed       // closed by the peer, or failed
  };
  struct Result {
    Outcome outcome = Outcome::kClosed;
    std::size_t bytes = 0;
  };

  // Server side of TLS with the settings of `tls` for `protocol`; plain text if `tls` is null.
  ByteStream(boost::asio::ip::tcp::socket socket, SSL_CTX* tls, TlsProtocol protocol);

  // The first reads include the TLS handshake.
  Result Read(std::span<std::uint8_t> into);
  Result Write(std::span<const std::uint8_t> from);

  // True if TLS has decrypted bytes that are not read yet. The socket need not be readable then.
  bool HasPending() const;
  // For waiting until it is readable or writable.
  boost::asio::ip::tcp::socket& socket() { return socket_; }
  // Returns the common name of the peer's verified certificate; empty if there is none. Valid after
  // the first read with kDone.
  std::string CommonName() const;
  // Sends TLS close_notify and shuts down the sending direction.
  void EndWriting();
  void Close();

 private:
  Result TlsResult(int returned);

  boost::asio::ip::tcp::socket socket_;
  std::unique_ptr<SSL, decltype(&SSL_free)> tls_;  // null: plain text
};

// One connection of a client, as the listener sees it. The protocols implement it. Stays on the
// thread of its io_context, except where noted.
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
