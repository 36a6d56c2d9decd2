#include "client/call_failure.h"

#include <fmt/format.h>
#include <motiondb/call_error.h>
#include <motiondb/field_violation.h>
#include <motiondb/v1/error.pb.h>

#include <string>
#include <utility>

#include "absl/strings/cord.h"

namespace motiondb::client {

namespace {

// Compares types, the part after the last slash; the prefix of a type URL may differ.
bool IsOfType(const google::protobuf::Any& any, absl::string_view url) {
  const std::string type(url.substr(url.rfind('/')));
  const std::string& given = any.type_url();
  return given.size() >= type.size() &&
         given.compare(given.size() - type.size(), type.size(), type) == 0;
}

void AppendViolations(const v1::BadRequest& bad_request, std::string& message) {
  const std::string said = message;
  for (const auto& violation : bad_request.field_violations()) {
    if (said.find(violation.description()) != std::string::npos) continue;
    fmt::format_to(std::back_inserter(message), "{}{}: {}", message.empty() ? "" : "; ",
                   violation.field(), violation.description());
  }
}

// Errors that are fully explained by their message, without the log of the server.
bool IsAboutTheRequest(absl::StatusCode code) {
  return code == absl::StatusCode::kInvalidArgument || code == absl::StatusCode::kNotFound ||
         code == absl::StatusCode::kAlreadyExists || code == absl::StatusCode::kOutOfRange ||
         code == absl::StatusCode::kFailedPrecondition;
}

// Parses the payload `url` into `message`; returns false if there is none.
template <typename Message>
bool Payload(const absl::Status& status, absl::string_view url, Message& message) {
  const auto payload = status.GetPayload(url);
  return payload.has_value() && message.ParseFromString(std::string(*payload));
}

}  // namespace

absl::Status FromGrpc(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  std::string message = status.error_message();
  v1::BadRequest violations;
  v1::Status details;
  if (details.ParseFromString(status.error_details())) {
    for (const auto& detail : details.details()) {
      v1::BadRequest bad_request;
      if (IsOfType(detail, kBadRequestTypeUrl) && bad_request.ParseFromString(detail.value())) {
        violations.MergeFrom(bad_request);
      }
    }
  }
  AppendViolations(violations, message);
  // gRPC and absl number the canonical codes alike.
  absl::Status result(static_cast<absl::StatusCode>(status.error_code()), message);
  for (const auto& detail : details.details()) {
    for (const absl::string_view url :
         {kErrorInfoTypeUrl, kRequestInfoTypeUrl, kRetryInfoTypeUrl}) {
      if (IsOfType(detail, url)) result.SetPayload(url, absl::Cord(detail.value()));
    }
  }
  if (violations.field_violations_size() > 0) {
    result.SetPayload(kBadRequestTypeUrl, absl::Cord(violations.SerializeAsString()));
  }
  const std::string request_id = RequestId(result);
  if (request_id.empty() || IsAboutTheRequest(result.code())) return result;
  return WithMessage(result, fmt::format("{} (request {})", message, request_id));
}

absl::Status WithRequestId(absl::Status status, const std::string& request_id) {
  v1::RequestInfo info;
  info.set_request_id(request_id);
  status.SetPayload(kRequestInfoTypeUrl, absl::Cord(info.SerializeAsString()));
  return status;
}

absl::Status WithMessage(const absl::Status& status, const std::string& message) {
  absl::Status result(status.code(), message);
  status.ForEachPayload(
      [&](absl::string_view url, const absl::Cord& payload) { result.SetPayload(url, payload); });
  return result;
}

std::string ErrorReason(const absl::Status& status) {
  v1::ErrorInfo info;
  return Payload(status, kErrorInfoTypeUrl, info) ? info.reason() : "";
}

std::string ErrorMetadata(const absl::Status& status, const std::string& key) {
  v1::ErrorInfo info;
  if (!Payload(status, kErrorInfoTypeUrl, info)) return "";
  const auto found = info.metadata().find(key);
  return found == info.metadata().end() ? "" : found->second;
}

std::string RequestId(const absl::Status& status) {
  v1::RequestInfo info;
  return Payload(status, kRequestInfoTypeUrl, info) ? info.request_id() : "";
}

std::optional<std::chrono::milliseconds> RetryDelay(const absl::Status& status) {
  v1::RetryInfo info;
  if (!Payload(status, kRetryInfoTypeUrl, info)) return std::nullopt;
  return std::chrono::milliseconds(info.retry_delay().seconds() * 1000 +
                                   info.retry_delay().nanos() / 1'000'000);
}

std::vector<FieldViolation> FieldViolations(const absl::Status& status) {
  std::vector<FieldViolation> result;
  v1::BadRequest bad_request;
  if (!Payload(status, kBadRequestTypeUrl, bad_request)) return result;
  for (const auto& violation : bad_request.field_violations()) {
    result.push_back({violation.field(), violation.description()});
  }
  return result;
}

namespace {

constexpr absl::string_view kFailureUrl = "motiondb/connect-failure";

// gRPC reports the reason only in its message. The first match counts.
constexpr std::pair<const char*, ConnectFailure> kWords[] = {
    {"Connection refused", ConnectFailure::kNotListening},
    {"No such file or directory", ConnectFailure::kNotListening},  // of unix:PATH
    {"DNS resolution failed", ConnectFailure::kUnknownHost},
    {"certificate verify failed", ConnectFailure::kUntrusted},
    {"CERTIFICATE_VERIFY_FAILED", ConnectFailure::kUntrusted},  // BoringSSL
    {"is not in peer certificate", ConnectFailure::kNameMismatch},
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

// Returns the part of gRPC's message about the last address.
std::string LastError(const std::string& grpc_message) {
  constexpr absl::string_view kBefore = "last error: ";
  const size_t at = grpc_message.find(kBefore.data());
  return at == std::string::npos ? grpc_message : grpc_message.substr(at + kBefore.size());
}

std::string Authority(const TlsOptions& tls) {
  return tls.ca_file.empty() ? "an authority that this system trusts" : tls.ca_file;
}

std::string ClosedText(const ClientOptions& options) {
  if (!options.tls) return "it closes connections in plain text; it probably requires TLS";
  if (options.tls->certificate_file.empty()) {
    return "it closes TLS connections; it probably requires a client certificate";
  }
  return fmt::format(
      "it closes TLS connections; it probably does not trust the authority that signed {}",
      options.tls->certificate_file);
}

std::string NotGrpcText(const ClientOptions& options) {
  return options.tls ? "it uses TLS, but not gRPC; the port belongs to another program"
                     : "it does not use gRPC in plain text; the port belongs to another program, "
                       "or requires TLS";
}

std::string UnusableText(const ClientOptions& options) {
  const TlsOptions tls = options.tls.value_or(TlsOptions());
  const std::string files =
      fmt::format("{}{}{}", tls.ca_file, tls.ca_file.empty() ? "" : " or ", tls.certificate_file);
  if (tls.certificate_file.empty()) return Authority(tls) + ": contains no valid certificate";
  return fmt::format("{}: contains no valid certificate, or {} is not the key of {}", files,
                     tls.key_file, tls.certificate_file);
}

std::string Reason(ConnectFailure failure, const ClientOptions& options,
                   const std::string& grpc_message) {
  const TlsOptions tls = options.tls.value_or(TlsOptions());
  switch (failure) {
    case ConnectFailure::kNotListening:
      return fmt::format("nothing listens there; start a server with `motiondbd --listen {}`",
                         options.server);
    case ConnectFailure::kUnknownHost:
      // The last part of gRPC's message is the error of the resolver.
      return fmt::format("the host name cannot be resolved: {}",
                         grpc_message.substr(grpc_message.rfind(": ") + 2));
    case ConnectFailure::kNoResponse:
      return "no response; the server hangs, a firewall blocks it, or the port belongs to another "
             "program";
    case ConnectFailure::kClosed:
      return ClosedText(options);
    case ConnectFailure::kNotGrpc:
      return NotGrpcText(options);
    case ConnectFailure::kNotTls:
      return "it does not use TLS";
    case ConnectFailure::kUntrusted:
      return fmt::format("its certificate is not signed by {}, or has expired", Authority(tls));
    case ConnectFailure::kNameMismatch:
      return fmt::format("its certificate is not for {}",
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
  if (grpc_message.empty()) return ConnectFailure::kNoResponse;
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
