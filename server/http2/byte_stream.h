// A connected TCP socket that never blocks, with or without TLS. Not thread-safe.
#pragma once

#include <openssl/ssl.h>

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace motiondb::server {

class ByteStream {
 public:
  // What a read or a write came to.
  enum class Outcome {
    kDone,        // `bytes` were moved, at least one
    kWantsRead,   // nothing was: try again when the socket is readable
    kWantsWrite,  // nothing was: try again when the socket is writable
    kClosed       // the peer closed it, or it failed
  };
  struct Result {
    Outcome outcome = Outcome::kClosed;
    std::size_t bytes = 0;
  };

  // Serves TLS with the settings of `tls`; plain text where it is null.
  ByteStream(boost::asio::ip::tcp::socket socket, SSL_CTX* tls);

  // The TLS handshake is part of the first reads.
  Result Read(std::span<std::uint8_t> into);
  Result Write(std::span<const std::uint8_t> from);

  // Whether a read would move bytes although the socket has none.
  bool HasPending() const;
  // For waits until it is readable or writable.
  boost::asio::ip::tcp::socket& socket() { return socket_; }
  // The common name of the peer's certificate, which was verified; empty if there is none. Known
  // after the first read that moved bytes.
  std::string CommonName() const;
  // Tells the peer that nothing more comes.
  void EndWriting();
  void Close();

 private:
  Result TlsResult(int returned);

  boost::asio::ip::tcp::socket socket_;
  std::unique_ptr<SSL, decltype(&SSL_free)> tls_;  // null: plain text
};

}  // namespace motiondb::server
