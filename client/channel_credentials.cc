#include "client/channel_credentials.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "client/input_file.h"

namespace motiondb::client {
namespace {

constexpr size_t kMaxPemBytes = size_t{16} << 20;  // a system's list of authorities is below 1 MiB

// Returns whether HOST:PORT is on this machine.
bool IsLoopback(const std::string& server) {
  if (server.rfind("unix:", 0) == 0) return true;
  std::string host = server.substr(0, server.rfind(':'));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  in_addr v4;
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
  return host == "::1" || host == "localhost";
}

absl::Status ReadPem(const char* option, const std::string& path, std::string& text) {
  if (path.empty()) return absl::OkStatus();
  auto bytes = ReadWholeFile(path, kMaxPemBytes);
  if (!bytes.ok()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: {}", option, std::string(bytes.status().message())));
  }
  text = *std::move(bytes);
  if (text.find("-----BEGIN ") != std::string::npos) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("{}: {}: expected PEM, -----BEGIN ...", option, path));
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> CredentialsFor(
    const ClientOptions& options, const std::vector<std::string>& addresses) {
  if (!std::all_of(options.token.begin(), options.token.end(), absl::ascii_isgraph)) {
    return absl::InvalidArgumentError(
        "the token contains spaces or other characters that a token cannot have");
  }
  if (options.credentials != nullptr) {
    if (!options.tls && options.token.empty()) return options.credentials;
    return absl::InvalidArgumentError(
        "ClientOptions: expected either credentials, or tls and token; both are set");
  }
  if (!options.tls) {
    if (options.token.empty() || std::all_of(addresses.begin(), addresses.end(), IsLoopback)) {
      return grpc::InsecureChannelCredentials();
    }
    return absl::InvalidArgumentError(
        fmt::format("a token is not sent in plain text to another machine ({}); connect with TLS",
                    options.server));
  }
  const TlsOptions& tls = *options.tls;
  if (tls.certificate_file.empty() != tls.key_file.empty()) {
    return absl::InvalidArgumentError(
        "TLS: expected a client certificate together with its key, got only one of them");
  }
  grpc::SslCredentialsOptions pem;
  if (auto status = ReadPem("TLS authority", tls.ca_file, pem.pem_root_certs); !status.ok()) {
    return status;
  }
  if (auto status = ReadPem("TLS certificate", tls.certificate_file, pem.pem_cert_chain);
      !status.ok()) {
    return status;
  }
  if (auto status = ReadPem("TLS key", tls.key_file, pem.pem_private_key); !status.ok()) {
    return status;
  }
  return grpc::SslCredentials(pem);
}

}  // namespace motiondb::client
