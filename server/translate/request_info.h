// The id of a call in its error. Safe to call from any thread.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

namespace motiondb::server {

inline constexpr char kRequestInfoUrl[] = "type.googleapis.com/google.rpc.RequestInfo";

// The error with a RequestInfo after its other details.
grpc::Status WithRequestInfo(const grpc::Status& error, const std::string& request_id);

}  // namespace motiondb::server
