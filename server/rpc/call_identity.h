// Which call of the contract a request is, and what its context says about its caller.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/server_context.h>

#include <string>
#include <vector>

#include "server/security/authorize.h"
#include "server/security/role_table.h"

namespace motiondb::server {

// Which call of the contract a request belongs to. Safe to use from any thread.
struct Method {
  std::string name;                // "DatabaseService.GetDatabase"
  const CallRule* rule = nullptr;  // null: the table has none, and the call is refused
  bool streaming = false;          // on either side
  bool waits = false;              // for somebody else, as long as the request's timeout says
  RequestClass request_class = RequestClass::kLight;
  Pool pool = Pool::kRequests;  // where it is worked on

  // Whether as many at a time as the pool has threads could keep others waiting: then clients take
  // turns, and threads stay with the others.
  bool TakesTurns(RequestClass as) const {
    return as == RequestClass::kHeavy || (pool == Pool::kChanges && !rule->urgent);
  }
};

// The method of the role table whose input is this type: every call has a request type of its own.
Method FindMethod(const google::protobuf::Descriptor& request_type);

// The same, looked up once.
template <typename Request>
const Method& MethodOf() {
  static const Method method = FindMethod(*Request::descriptor());
  return method;
}

// The names of all calls of the contract.
std::vector<std::string> MethodNames();

// What a call's context says about its caller. Safe to call from any thread.

// `address` is the peer's.
Evidence EvidenceOf(const grpc::CallbackServerContext& context, const std::string& address);

// As gRPC names a peer, "ipv4:127.0.0.1:50000": the listener's word, not the client's.
std::string PeerOf(const grpc::CallbackServerContext& context);

// The address without its port, "127.0.0.1", "::1", "unix", of a peer as gRPC has it:
// "ipv4:127.0.0.1:50000", "ipv6:%5B::1%5D:50000".
std::string AddressOf(const std::string& peer);

// The caller's `x-request-id`, if it is 1 to 128 printable characters and holds no
// token, else a new one.
std::string RequestIdOf(const grpc::CallbackServerContext& context);

}  // namespace motiondb::server
