// Who makes a call, and what was found out about them.
#pragma once

#include <memory>
#include <string>

#include "storage/access_store.h"

namespace motiondb::server {

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

}  // namespace motiondb::server
