// A connected non-blocking TCP socket, with or without TLS. Not thread-safe.
#pragma once

#include <openssl/ssl.h>

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "server/security/tls.h"

namespace motiondb::server {

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

}  // namespace motiondb::server
