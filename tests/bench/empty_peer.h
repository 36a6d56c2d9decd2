// A gRPC server that does nothing but answer: what any server on this machine pays for the same
// messages. It takes the calls of motiondb's own clients, by method name, does not parse what they
// send, and answers each message with the same bytes at once.
//
// Thread-safe. Owns its socket; streams must have ended before it is destroyed.
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

  // Listens on a free loopback port. Methods by path: "/motiondb.v1.QueryService/Recognize".
  // UNAVAILABLE where it cannot.
  static absl::StatusOr<std::unique_ptr<EmptyPeer>> Start(std::map<std::string, Method> methods);
  ~EmptyPeer();

  // HOST:PORT that clients reach it at.
  const std::string& address() const { return address_; }

 private:
  class Service;
  EmptyPeer();

  std::unique_ptr<Service> service_;
  std::unique_ptr<grpc::Server> grpc_;
  std::string address_;
};

}  // namespace motiondb::tests
