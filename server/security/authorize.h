// The rules of all calls, and the caller of a call and its permissions.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/engine/work/executor.h"
#include "storage/access_store.h"

namespace motiondb::server {

class KnownToken;

// The cost of a call. Calls of a class share its limits.
enum class RequestClass {
  kLight,   // milliseconds; a query with a large request is heavy
  kHeavy,   // much processor time, memory or disk; few run concurrently, in a fair queue
  kStream,  // open as long as the client wants, with little work for each message
};

// The resource of a call, for callers that may access only one database.
enum class Scope {
  kDatabase,   // the field names a database or a part of one
  kOperation,  // the field names an operation, which belongs to a database
  kList,       // returns only what the caller may see; the field, if set, names a database
  kServer      // more than one database: refused for a caller of one database
};

struct CallRule {
  std::string_view method;  // "DatabaseService.GetDatabase", of motiondb.v1
  storage::Role min_role;
  bool recorded;  // in the audit log: the call changes something or copies the whole store
  RequestClass request_class;
  Scope scope;
  std::string_view field;            // path of the resource's name in the (first) request message
  std::string_view collection = {};  // prefix of the name if the field has only an id; else empty
  // Thread pool of the handler: kChanges if it may wait for the store's writer, kMaintenance if it
  // reads or writes the whole store without a time limit.
  Pool pool = Pool::kRequests;
  bool urgent = false;  // does not wait in the queue of changes
};

// The rules of all calls: required role, request class, audit, scope and thread pool. One row for
// each call. A test compares the table with the service definitions.
std::span<const CallRule> CallRules();

// Returns null for an unknown method.
const CallRule* FindCallRule(std::string_view method);

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
