// Why a call failed or a channel did not connect, as an absl::Status.
#pragma once

#include <grpcpp/support/status.h>
#include <motiondb/client_options.h>

#include <optional>
#include <string>

#include "absl/status/status.h"

namespace motiondb::client {

// How a failed call becomes an absl::Status. Pure functions, safe on any thread.

// The same canonical code and message. The field violations of `grpc-status-details-bin` are
// appended as "field: description" where the message does not say them already, and attached as a
// payload under kBadRequestTypeUrl.
//
// The call's id and when to try again are attached under kRequestInfoTypeUrl and kRetryInfoTypeUrl.
// Unless the error is about what was asked for (INVALID_ARGUMENT, NOT_FOUND, ALREADY_EXISTS,
// FAILED_PRECONDITION, OUT_OF_RANGE), the message names the id, "(request ...)", for a person to
// look up in the server's log.
absl::Status FromGrpc(const grpc::Status& status);

// The same with a call's id attached.
absl::Status WithRequestId(absl::Status status, const std::string& request_id);

// The same code and payloads with another message.
absl::Status WithMessage(const absl::Status& status, const std::string& message);

// Why a channel did not connect, for a person who has options to change. Pure functions, safe on
// any thread.
enum class ConnectFailure {
  kNotListening,      // the host says that nobody listens at the port
  kUnknownHost,       // no address is found for the name
  kSilent,            // nothing at all came back, or nothing after the connection was made
  kClosed,            // the connection was made and closed again
  kNotGrpc,           // an answer came that is not gRPC's
  kNotTls,            // an answer came that is not TLS's
  kUntrusted,         // the server's certificate is not signed by whom it should be, or ran out
  kOtherName,         // the server's certificate is made out to another
  kUnusableTlsFiles,  // what options.tls names is no certificate, or no key for it
  kOther,
};

// What gRPC's words for the last attempt mean.
ConnectFailure ConnectFailureOf(const std::string& grpc_message);

// UNAVAILABLE: the address, how long it was tried and what is likely wrong, with the failure
// attached for AttachedConnectFailure. `grpc_message` is empty where no attempt came to an end.
absl::Status ConnectError(const ClientOptions& options, const std::string& grpc_message);

// What a status says of connecting; nothing where it is about something else.
std::optional<ConnectFailure> AttachedConnectFailure(const absl::Status& status);

}  // namespace motiondb::client
