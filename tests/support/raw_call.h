// A gRPC call without generated code: method name and bytes.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace motiondb::tests {

struct RawAnswer {
  grpc::Status status;
  std::string bytes;  // of the first response message
};

using Headers = std::vector<std::pair<std::string, std::string>>;

// Sends one request message, reads all responses and keeps the first: a unary call, or one round of
// a stream.
RawAnswer RawCall(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::string& request, const Headers& headers = {});

}  // namespace motiondb::tests
