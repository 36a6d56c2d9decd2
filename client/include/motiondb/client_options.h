// How a client reaches its server, and how long it waits. Plain values: copy them freely.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace grpc {
class ChannelCredentials;
}

namespace motiondb::client {

// As a time to wait: no limit.
inline constexpr std::chrono::milliseconds kNoTimeout = std::chrono::milliseconds::max();

// A connection by TLS. Files are PEM.
struct TlsOptions {
  // Who signs the server's certificate; empty: the authorities that the system trusts.
  std::string ca_file;
  // The client's own, for a server that asks for one; both or neither.
  std::string certificate_file;
  std::string key_file;
  // Whom the server's certificate is made out to, where that is not the host of its address.
  std::string server_name;
};

struct ClientOptions {
  // Address of the server, HOST:PORT.
  std::string server = "127.0.0.1:50051";
  // How long Client::Connect tries. A server that is just starting is reached within it.
  std::chrono::milliseconds connect_timeout{2000};
  // How long a call may take where its CallOptions do not say.
  std::chrono::milliseconds call_timeout{60'000};
  // Largest message taken from the server. Files, states and nodes come in blocks far below it;
  // what grows are plans, which come whole: ten alternatives of 120 s at 120 Hz on a skeleton of 31
  // joints, each with its BVH file, are some 270 MB.
  int max_receive_bytes = 512 << 20;
  // Largest message sent: an observation carries its file whole.
  int max_send_bytes = 64 << 20;
  // By TLS; absent means plain text.
  std::optional<TlsOptions> tls;
  // Bearer token, sent with every call; never over plain text to another machine.
  std::string token;
  // In place of `tls` and `token`, any gRPC credentials.
  std::shared_ptr<grpc::ChannelCredentials> credentials;
};

// What one call does differently.
struct CallOptions {
  // How long the call may take, or kNoTimeout. Absent: ClientOptions::call_timeout, except where a
  // function says otherwise.
  std::optional<std::chrono::milliseconds> timeout;
};

}  // namespace motiondb::client
