// A gRPC server that only answers: the cost of the same messages on any server of this machine. It
// accepts the calls of motiondb's clients by method name, does not parse requests, and answers each
// message immediately with the same bytes. Thread-safe. Streams must have ended before it is
// destroyed.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace grpc {
class Server;
}

namespace motiondb::tests {

class EmptyPeer {
 public:
  enum class Shape { kUnary, kStream };
  struct Method {
    Shape shape = Shape::kUnary;
    std::string reply;  // a message, serialized
  };

  // Listens on a free loopback port; UNAVAILABLE if it cannot. Methods by path:
  // "/motiondb.v1.QueryService/Recognize".
  static absl::StatusOr<std::unique_ptr<EmptyPeer>> Start(std::map<std::string, Method> methods);
  ~EmptyPeer();

  // Returns HOST:PORT.
  const std::string& address() const { return address_; }

 private:
  class Service;
  EmptyPeer();

  std::unique_ptr<Service> service_;
  std::unique_ptr<grpc::Server> grpc_;
  std::string address_;
};

}  // namespace motiondb::tests
