// A call by a client that knows nothing of the service but its wire: method name and bytes.
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

// Sends one request message and reads the responses, of which the first is kept: a unary call, or
// one turn of a stream.
RawAnswer RawCall(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                  const std::string& request, const Headers& headers = {});

}  // namespace motiondb::tests
