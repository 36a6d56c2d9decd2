// Who may make which call, and what it is to the server: one table, a row for every call of the
// contract. A test walks it against the service definitions, so that none is left out and no row
// outlives its call. Safe to use from any thread.
#pragma once

#include <span>
#include <string_view>

#include "server/engine/executor.h"
#include "storage/access_store.h"

namespace motiondb::server {

// What a call costs the server. Calls of a class share its limits.
enum class RequestClass {
  kLight,   // milliseconds; a query with a large request is heavy
  kHeavy,   // much processor time, memory or disk: few run at a time, and clients take turns
  kStream,  // as long as the client likes, a little at a time
};

// What a call touches, for callers who may touch one database alone.
enum class Scope {
  kDatabase,   // the field names a database, or something in one
  kOperation,  // the field names an operation, which belongs to a database
  kList,       // lists what the caller may see; the field, where it is set, names a database
  kServer      // more than one database: not for a caller of one
};

struct CallRule {
  std::string_view method;  // "DatabaseService.GetDatabase", of motiondb.v1
  storage::Role least_role;
  bool recorded;  // in the record of changes: it changes something, or copies all there is
  RequestClass request_class;
  Scope scope;
  std::string_view field;  // path in the request, or in the first of a stream: what it is about
  std::string_view collection = {};  // what the field's value is an id in, where it is no full name
  // Whose threads do the work: Pool::kChanges where it may wait for the store's writer, kUpkeep
  // where it is about all that is stored, and takes as long as it takes.
  Pool pool = Pool::kRequests;
  bool urgent = false;  // a change that waits for no other to be made
};

std::span<const CallRule> CallRules();

// Null if there is none.
const CallRule* FindCallRule(std::string_view method);

}  // namespace motiondb::server
