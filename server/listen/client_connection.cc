#include "server/listen/client_connection.h"

#include <openssl/err.h>
#include <openssl/x509.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <new>
#include <utility>

namespace motiondb::server {
namespace {

SSL* MakeTls(SSL_CTX* context, TlsProtocol protocol, int descriptor) {
  if (context == nullptr) return nullptr;
  SSL* const tls = SSL_new(context);
  if (tls == nullptr || SSL_set_fd(tls, descriptor) != 1) {
    SSL_free(tls);
    ERR_clear_error();
    throw std::bad_alloc();
  }
  SetProtocol(*tls, protocol);
  SSL_set_accept_state(tls);
  return tls;
}

ByteStream::Result SystemResult(ssize_t returned, ByteStream::Outcome if_blocked) {
  if (returned > 0) return {ByteStream::Outcome::kDone, static_cast<std::size_t>(returned)};
  const bool blocked = returned < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
  return {blocked ? if_blocked : ByteStream::Outcome::kClosed};
}

int AtMostInt(std::size_t size) { return static_cast<int>(std::min<std::size_t>(size, INT_MAX)); }

}  // namespace

ByteStream::ByteStream(boost::asio::ip::tcp::socket socket, SSL_CTX* tls, TlsProtocol protocol)
    : socket_(std::move(socket)), tls_(MakeTls(tls, protocol, socket_.native_handle()), SSL_free) {}

ByteStream::Result ByteStream::Read(std::span<std::uint8_t> into) {
  if (tls_ != nullptr) {
    ERR_clear_error();
    return TlsResult(SSL_read(tls_.get(), into.data(), AtMostInt(into.size())));
  }
  return SystemResult(recv(socket_.native_handle(), into.data(), into.size(), 0),
                      Outcome::kWantsRead);
}

ByteStream::Result ByteStream::Write(std::span<const std::uint8_t> from) {
  if (tls_ != nullptr) {
    ERR_clear_error();
    return TlsResult(SSL_write(tls_.get(), from.data(), AtMostInt(from.size())));
  }
  return SystemResult(send(socket_.native_handle(), from.data(), from.size(), MSG_NOSIGNAL),
                      Outcome::kWantsWrite);
}

ByteStream::Result ByteStream::TlsResult(int returned) {
  if (returned > 0) return {Outcome::kDone, static_cast<std::size_t>(returned)};
  switch (SSL_get_error(tls_.get(), returned)) {
    case SSL_ERROR_WANT_READ:
      return {Outcome::kWantsRead};
    case SSL_ERROR_WANT_WRITE:
      return {Outcome::kWantsWrite};
    default:
      ERR_clear_error();
      return {Outcome::kClosed};
  }
}

bool ByteStream::HasPending() const { return tls_ != nullptr && SSL_pending(tls_.get()) > 0; }

std::string ByteStream::CommonName() const {
  if (tls_ == nullptr) return "";
  const X509* const certificate = SSL_get0_peer_certificate(tls_.get());
  if (certificate == nullptr) return "";
  X509_NAME* const subject = X509_get_subject_name(certificate);
  const int index = X509_NAME_get_index_by_NID(subject, NID_commonName, -1);
  if (index < 0) return "";
  unsigned char* text = nullptr;
  const int size =
      ASN1_STRING_to_UTF8(&text, X509_NAME_ENTRY_get_data(X509_NAME_get_entry(subject, index)));
  if (size < 0) return "";
  std::string name(reinterpret_cast<const char*>(text), static_cast<std::size_t>(size));
  OPENSSL_free(text);
  return name;
}

void ByteStream::EndWriting() {
  if (tls_ != nullptr && SSL_is_init_finished(tls_.get())) {
    ERR_clear_error();
    SSL_shutdown(tls_.get());
    ERR_clear_error();
  }
  boost::system::error_code ignored;
  socket_.shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
}

void ByteStream::Close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

}  // namespace motiondb::server
