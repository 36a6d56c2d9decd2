// Who makes a call, and whether they may.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/security/role_table.h"
#include "storage/access_store.h"

namespace motiondb::server {

// Who makes a call, and what was found out about them.
class KnownToken;

// What a call brings to show who makes it.
struct Evidence {
  std::string authorization;  // the header's value; empty where there is none
  std::string common_name;    // of the client's certificate, verified; empty where there is none
  std::string address;        // the peer's, without port
};

struct Caller {
  std::string principal;  // `tokens/{token}`, `certificate:{common name}`, or `anonymous`
  storage::Role role = storage::Role::kReader;
  std::string database;                     // the id of the one that it may touch; empty: all
  std::shared_ptr<const KnownToken> token;  // null where it is known by something else
};

inline constexpr char kAnonymous[] = "anonymous";

// Metadata that the listener (server/http2) adds to each call, and takes from no client: its peer
// as gRPC names one, and the common name of its certificate, verified, if it has one.
inline constexpr char kPeerMetadata[] = "motiondb-peer";
inline constexpr char kCommonNameMetadata[] = "motiondb-common-name-bin";

// Whether a caller may make a call. Pure; safe to call from any thread.

// `resource` is what the rule's field names; for an operation, the database that it belongs to, or
// empty. PERMISSION_DENIED, saying what is lacking. What the caller may not touch is refused
// whether it exists or not.
absl::Status Authorize(const Caller& caller, const CallRule& rule, std::string_view resource);

const char* RoleName(storage::Role role);

}  // namespace motiondb::server
