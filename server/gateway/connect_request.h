// The head of a request of the Connect protocol, and the responses that depend on it alone.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/status.h>

#include <chrono>
#include <optional>
#include <string>

#include "server/http1/http_exchange.h"

namespace motiondb::server {

struct ConnectRequest {
  const google::protobuf::MethodDescriptor* method = nullptr;
  bool is_json = true;      // otherwise proto
  bool streams = false;     // messages in envelopes; the response has HTTP status 200
  bool sends_gzip = false;  // the body, or envelopes that say so
  bool accepts_gzip = false;
  std::optional<std::chrono::milliseconds> timeout;
  std::string authorization;  // empty if absent
  std::string request_id;     // of the client; empty if absent

  std::string content_type() const;
  std::string path() const;  // "/motiondb.v1.QueryService/Recognize"
};

// Why a request is refused.
struct ConnectRefusal {
  grpc::Status error;
  unsigned http_status = 0;  // of a unary response; 0: that of the code
  HttpFields fields;         // of the response, besides those of every error
};

// Reads the head into `parsed`, up to the first fault. Returns it: an unknown path (404; `parsed`
// has no method), no POST (405), a content type that the method does not have (415), or an error.
std::optional<ConnectRefusal> ParseConnectRequest(const HttpRequest& request,
                                                  ConnectRequest& parsed);

// Returns the response with an error: JSON, or for a stream its last envelope. `http_status`: of a
// unary response; 0: that of the code.
HttpResponse ErrorResponse(const ConnectRequest& request, const grpc::Status& error,
                           unsigned http_status = 0);

// Returns the head of a stream's response.
HttpResponse StreamHead(const ConnectRequest& request);

}  // namespace motiondb::server
