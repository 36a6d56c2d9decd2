// What a call's context says about its caller. Safe to call from any thread.
#pragma once

#include <grpcpp/server_context.h>

#include <string>

#include "server/security/caller.h"

namespace motiondb::server {

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
