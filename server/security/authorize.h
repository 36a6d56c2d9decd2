// The caller of a call and its permissions.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/security/call_rules.h"
#include "storage/access_store.h"

namespace motiondb::server {

class KnownToken;

// The credentials of a call, as received.
struct PeerCredentials {
  std::string authorization;  // value of the header; empty if absent
  std::string common_name;    // of the verified client certificate; empty if absent
  std::string address;        // of the peer, without port
};

// An authenticated caller.
struct Caller {
  std::string principal;  // `tokens/{token}`, `certificate:{common name}`, or `anonymous`
  storage::Role role = storage::Role::kReader;
  std::string database;                     // id of the only database allowed; empty: all
  std::shared_ptr<const KnownToken> token;  // null if authenticated without a token
};

inline constexpr char kAnonymous[] = "anonymous";

// Metadata that the listener (server/http2) adds to each call: the peer as gRPC names it, and the
// common name of its verified certificate, if any. The listener ignores such headers of clients.
inline constexpr char kPeerMetadata[] = "motiondb-peer";
inline constexpr char kCommonNameMetadata[] = "motiondb-common-name-bin";

// Checks whether `caller` may make a call. `resource` is the value of the rule's field; for an
// operation, the name of its database, or empty. Returns PERMISSION_DENIED with the reason. The
// result does not depend on whether the resource exists.
absl::Status Authorize(const Caller& caller, const CallRule& rule, std::string_view resource);

const char* RoleName(storage::Role role);

}  // namespace motiondb::server
