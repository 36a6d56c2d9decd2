// JSON of the Connect protocol (connectrpc.com/docs/protocol). Messages: by the mapping of proto3
// (protobuf.dev/programming-guides/json) and the descriptors of the generated code. Errors: code,
// message and details.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns the serialized message. Field names may be those of the proto or in camelCase. Empty text
// is the empty message. INVALID_ARGUMENT with the place: no JSON, an unknown field, a wrong type,
// invalid UTF-8, nested too deeply.
absl::StatusOr<std::string> ProtoFromJson(const google::protobuf::Descriptor& type,
                                          std::string_view json);

// Returns JSON with names in camelCase and without default values. INTERNAL if `bytes` is no
// message of this type.
absl::StatusOr<std::string> JsonFromProto(const google::protobuf::Descriptor& type,
                                          const std::string& bytes);

// Returns INVALID_ARGUMENT if `bytes` is no message of this type, which must be generated code.
absl::Status CheckProto(const google::protobuf::Descriptor& type, const std::string& bytes);

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
