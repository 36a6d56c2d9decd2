#include "client/connect_failure.h"

#include <fmt/format.h>

#include <utility>

#include "absl/strings/cord.h"

namespace motiondb::client {
namespace {

constexpr absl::string_view kFailureUrl = "motiondb/connect-failure";

// gRPC tells by words alone. The first that is found counts.
constexpr std::pair<const char*, ConnectFailure> kWords[] = {
    {"Connection refused", ConnectFailure::kNotListening},
    {"No such file or directory", ConnectFailure::kNotListening},  // unix:PATH
    {"DNS resolution failed", ConnectFailure::kUnknownHost},
    {"certificate verify failed", ConnectFailure::kUntrusted},
    {"CERTIFICATE_VERIFY_FAILED", ConnectFailure::kUntrusted},  // BoringSSL's
    {"is not in peer certificate", ConnectFailure::kOtherName},
    {"wrong version number", ConnectFailure::kNotTls},
    {"WRONG_VERSION_NUMBER", ConnectFailure::kNotTls},
    {"Failed parsing HTTP/2", ConnectFailure::kNotGrpc},
    {"http1.x server", ConnectFailure::kNotGrpc},
    {"empty address list", ConnectFailure::kUnusableTlsFiles},
    {"Socket closed", ConnectFailure::kClosed},
    {"Endpoint read failed", ConnectFailure::kClosed},
    {"Connection reset by peer", ConnectFailure::kClosed},
    {"Broken pipe", ConnectFailure::kClosed},
    {"Handshake read failed", ConnectFailure::kClosed},
};

// What is said by gRPC of the last address alone.
std::string LastError(const std::string& grpc_message) {
  constexpr absl::string_view kBefore = "last error: ";
  const size_t at = grpc_message.find(kBefore.data());
  return at == std::string::npos ? grpc_message : grpc_message.substr(at + kBefore.size());
}

std::string Authority(const TlsOptions& tls) {
  return tls.ca_file.empty() ? "an authority that this system trusts" : tls.ca_file;
}

std::string ClosedText(const ClientOptions& options) {
  if (!options.tls)
    return "what is there closes connections in plain text, as a server by TLS does";
  if (options.tls->certificate_file.empty()) {
    return "what is there closes connections by TLS, as a server does that asks for a client's "
           "certificate";
  }
  return fmt::format(
      "what is there closes connections by TLS, as a server does that does not trust who signed {}",
      options.tls->certificate_file);
}

std::string NotGrpcText(const ClientOptions& options) {
  return options.tls ? "what is there speaks TLS, but not gRPC: it is another program's port"
                     : "what is there does not speak gRPC in plain text: it is another program's "
                       "port, or one for TLS";
}

std::string UnusableText(const ClientOptions& options) {
  const TlsOptions tls = options.tls.value_or(TlsOptions());
  const std::string files =
      fmt::format("{}{}{}", tls.ca_file, tls.ca_file.empty() ? "" : " or ", tls.certificate_file);
  if (tls.certificate_file.empty()) return Authority(tls) + ": holds no certificate of use";
  return fmt::format("{}: holds no certificate of use, or {} is not the key of {}", files,
                     tls.key_file, tls.certificate_file);
}

std::string Reason(ConnectFailure failure, const ClientOptions& options,
                   const std::string& grpc_message) {
  const TlsOptions tls = options.tls.value_or(TlsOptions());
  switch (failure) {
    case ConnectFailure::kNotListening:
      return fmt::format("nothing listens there: start one with `motiondbd --listen {}`",
                         options.server);
    case ConnectFailure::kUnknownHost:
      // The last of gRPC's words is the resolver's: the name may be wrong, or the name server away.
      return fmt::format("no address is found for that host: {}",
                         grpc_message.substr(grpc_message.rfind(": ") + 2));
    case ConnectFailure::kSilent:
      return "nothing came back: the server hangs, a firewall is between, or it is another "
             "program's port";
    case ConnectFailure::kClosed:
      return ClosedText(options);
    case ConnectFailure::kNotGrpc:
      return NotGrpcText(options);
    case ConnectFailure::kNotTls:
      return "what is there does not speak TLS";
    case ConnectFailure::kUntrusted:
      return fmt::format("its certificate is not signed by {}, or is out of date", Authority(tls));
    case ConnectFailure::kOtherName:
      return fmt::format("its certificate is not made out to {}",
                         tls.server_name.empty() ? "that host" : tls.server_name);
    case ConnectFailure::kUnusableTlsFiles:
      return UnusableText(options);
    case ConnectFailure::kOther:
      break;
  }
  return LastError(grpc_message);
}

}  // namespace

ConnectFailure ConnectFailureOf(const std::string& grpc_message) {
  if (grpc_message.empty()) return ConnectFailure::kSilent;
  for (const auto& [words, failure] : kWords) {
    if (grpc_message.find(words) != std::string::npos) return failure;
  }
  return ConnectFailure::kOther;
}

absl::Status ConnectError(const ClientOptions& options, const std::string& grpc_message) {
  const ConnectFailure failure = ConnectFailureOf(grpc_message);
  absl::Status status = absl::UnavailableError(
      fmt::format("no motiondb server answered at {} within {:g} s: {}", options.server,
                  std::chrono::duration<double>(options.connect_timeout).count(),
                  Reason(failure, options, grpc_message)));
  status.SetPayload(kFailureUrl, absl::Cord(std::to_string(static_cast<int>(failure))));
  return status;
}

std::optional<ConnectFailure> AttachedConnectFailure(const absl::Status& status) {
  const auto payload = status.GetPayload(kFailureUrl);
  if (!payload.has_value()) return std::nullopt;
  return static_cast<ConnectFailure>(std::stoi(std::string(*payload)));
}

}  // namespace motiondb::client
