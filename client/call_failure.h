// Converts errors of calls and of connecting to absl::Status.
#pragma once

#include <grpcpp/support/status.h>
#include <motiondb/client_options.h>

#include <optional>
#include <string>

#include "absl/status/status.h"

namespace motiondb::client {

// Returns a status with the same canonical code and message. Appends the field violations of
// `grpc-status-details-bin` to the message as "field: description", unless it contains them, and
// attaches them as payload kBadRequestTypeUrl.
//
// Attaches request id and retry delay as payloads kRequestInfoTypeUrl and kRetryInfoTypeUrl.
// Appends "(request ID)" to the message, for the server's log, unless the request itself is wrong
// (INVALID_ARGUMENT, NOT_FOUND, ALREADY_EXISTS, FAILED_PRECONDITION, OUT_OF_RANGE).
absl::Status FromGrpc(const grpc::Status& status);

// Attaches a request id.
absl::Status WithRequestId(absl::Status status, const std::string& request_id);

// Replaces the message; keeps code and payloads.
absl::Status WithMessage(const absl::Status& status, const std::string& message);

// Why a channel did not connect.
enum class ConnectFailure {
  kNotListening,      // connection refused
  kUnknownHost,       // the host name does not resolve
  kNoResponse,        // no response, before or after the TCP connection was established
  kClosed,            // the peer closed the connection
  kNotGrpc,           // the response is not gRPC
  kNotTls,            // the response is not TLS
  kUntrusted,         // the server's certificate is not signed by a trusted authority, or expired
  kNameMismatch,      // the server's certificate has another name
  kUnusableTlsFiles,  // options.tls names an invalid certificate, or a key that does not match it
  kOther,
};

// Classifies gRPC's error message of the last attempt.
ConnectFailure ConnectFailureOf(const std::string& grpc_message);

// Returns UNAVAILABLE with address, timeout and the probable reason, and attaches the failure for
// AttachedConnectFailure. `grpc_message` is empty if no attempt ended.
absl::Status ConnectError(const ClientOptions& options, const std::string& grpc_message);

// Returns the attached failure, or nullopt if the error is not about connecting.
std::optional<ConnectFailure> AttachedConnectFailure(const absl::Status& status);

}  // namespace motiondb::client
