// Errors of the Connect protocol (connectrpc.com/docs/protocol): code, message and details as JSON.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

namespace motiondb::server {

// Returns the name of a code other than OK: "invalid_argument".
const char* ConnectCodeName(grpc::StatusCode code);

// Returns the HTTP status of a unary response with this code: 400.
unsigned HttpStatusOf(grpc::StatusCode code);

// Returns the error as JSON. Details are those of a motiondb.v1.Status in the error details: their
// type, their bytes, and, if the server knows the type, their JSON as `debug`.
std::string ConnectErrorJson(const grpc::Status& error);

// Returns the last message of a stream: {}, or {"error": ...}.
std::string EndOfStreamJson(const grpc::Status& status);

}  // namespace motiondb::server
