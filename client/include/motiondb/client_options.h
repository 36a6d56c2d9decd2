// Options of a connection and of a call.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace grpc {
class ChannelCredentials;
}

namespace motiondb::client {

// A timeout without a limit.
inline constexpr std::chrono::milliseconds kNoTimeout = std::chrono::milliseconds::max();

// Options of a TLS connection. Files are in PEM format.
struct TlsOptions {
  // Certificate authority of the server's certificate; empty: the authorities that the system
  // trusts.
  std::string ca_file;
  // The client's certificate and its key, for mutual TLS; both or neither.
  std::string certificate_file;
  std::string key_file;
  // Name in the certificates of all servers, if it differs from the host in the address.
  std::string server_name;
};

struct ClientOptions {
  // Address of the server, HOST:PORT or unix:PATH, or several with commas between them: servers of
  // one store, in the order in which they are tried. A name that resolves to several machines is
  // one address.
  std::string server = "127.0.0.1:50051";
  // Time limit of Client::Connect, which retries, so that a starting server is reached.
  std::chrono::milliseconds connect_timeout{2000};
  // Default time limit of a call.
  std::chrono::milliseconds call_timeout{60'000};
  // Maximum size of a received message. Only plans are large, because each is one message: ten
  // alternatives of 120 s at 120 Hz on a skeleton with 31 joints, with BVH files, are about 270 MB.
  int max_receive_bytes = 512 << 20;
  // Maximum size of a sent message. An observation contains its whole file.
  int max_send_bytes = 64 << 20;
  // Absent: plain text.
  std::optional<TlsOptions> tls;
  // Bearer token, sent with every call. Not sent in plain text to another machine.
  std::string token;
  // Any gRPC credentials, instead of `tls` and `token`.
  std::shared_ptr<grpc::ChannelCredentials> credentials;
};

// Options of one call.
struct CallOptions {
  // Time limit, or kNoTimeout. Absent: ClientOptions::call_timeout, or the default that the
  // function documents.
  std::optional<std::chrono::milliseconds> timeout;
};

}  // namespace motiondb::client
