#include "client/cli/connect_advice.h"

#include <fmt/format.h>

#include "client/connect_failure.h"
#include "client/grpc_status.h"

namespace motiondb::client {
namespace {

std::string ClosedAdvice(const GlobalOptions& global) {
  if (!UsesTls(global)) return "connect by TLS with --tls, or --tls-ca FILE";
  return global.tls.certificate_file.empty()
             ? "show one with --tls-certificate FILE and --tls-key FILE"
             : "show another with --tls-certificate FILE and --tls-key FILE";
}

std::string NotGrpcAdvice(const GlobalOptions& global) {
  const std::string address = "give the server's address with --server";
  return UsesTls(global) ? address : address + ", or connect by TLS with --tls or --tls-ca FILE";
}

std::string Advice(ConnectFailure failure, const GlobalOptions& global) {
  switch (failure) {
    case ConnectFailure::kNotListening:
      return "or give the address of one that runs with --server or MOTIONDB_SERVER";
    case ConnectFailure::kClosed:
      return ClosedAdvice(global);
    case ConnectFailure::kNotGrpc:
      return NotGrpcAdvice(global);
    case ConnectFailure::kNotTls:
      return "leave out --tls, and what else begins --tls- or MOTIONDB_TLS";
    case ConnectFailure::kUntrusted:
      return "name the file of who signed it with --tls-ca";
    case ConnectFailure::kOtherName:
      return "say whom it is made out to with --tls-server-name, or give that name with --server";
    case ConnectFailure::kUnusableTlsFiles:
      return "see --tls-ca, --tls-certificate and --tls-key";
    case ConnectFailure::kUnknownHost:
    case ConnectFailure::kSilent:
    case ConnectFailure::kOther:
      break;
  }
  return "give the server's address with --server or MOTIONDB_SERVER";
}

}  // namespace

absl::Status WithConnectAdvice(const absl::Status& status, const GlobalOptions& global) {
  const auto failure = AttachedConnectFailure(status);
  if (!failure) return status;
  return WithMessage(
      status, fmt::format("{}; {}", std::string(status.message()), Advice(*failure, global)));
}

}  // namespace motiondb::client
