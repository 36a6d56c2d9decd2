// Identifies the method and the caller of a request.
#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/server_context.h>

#include <string>
#include <vector>

#include "server/security/authorize.h"

namespace motiondb::server {

// An RPC with its rule.
struct Method {
  std::string name;                // "DatabaseService.GetDatabase"
  const CallRule* rule = nullptr;  // null: not in the table; the call is refused
  bool streaming = false;          // client or server streaming
  bool waits = false;              // waits, up to the timeout of the request
  RequestClass request_class = RequestClass::kLight;
  Pool pool = Pool::kRequests;  // threads for its work

  // True if calls of this method could occupy all threads of the pool. Then clients take turns, and
  // a thread stays free for other calls.
  bool TakesTurns(RequestClass as) const {
    return as == RequestClass::kHeavy || (pool == Pool::kChanges && !rule->urgent);
  }
};

// Returns the method with this input type. Every RPC has its own request type.
Method FindMethod(const google::protobuf::Descriptor& request_type);

// Like FindMethod, with one lookup for each type.
template <typename Request>
const Method& MethodOf() {
  static const Method method = FindMethod(*Request::descriptor());
  return method;
}

// Returns the names of all RPCs, "QueryService.Plan".
std::vector<std::string> MethodNames();

// `address`: of the peer.
PeerCredentials PeerCredentialsOf(const grpc::CallbackServerContext& context,
                                  const std::string& address);

// Returns the peer as set by the listener, in gRPC's format, "ipv4:127.0.0.1:50000". Clients cannot
// forge it.
std::string PeerOf(const grpc::CallbackServerContext& context);

// Returns the address of a peer without the port: "127.0.0.1" for "ipv4:127.0.0.1:50000", "::1" for
// "ipv6:%5B::1%5D:50000", or "unix".
std::string AddressOf(const std::string& peer);

// Returns the id that a client sent (`x-request-id`) if it has 1 to 128 printable characters and no
// token; otherwise a new id.
std::string UsableRequestId(const std::string& sent_id);
std::string RequestIdOf(const grpc::CallbackServerContext& context);

}  // namespace motiondb::server
