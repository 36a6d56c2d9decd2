// The rules of all calls: required role, request class, audit, scope and thread pool. One row for
// each call. A test compares the table with the service definitions.
#pragma once

#include <span>
#include <string_view>

#include "server/engine/work/executor.h"
#include "storage/access_store.h"

namespace motiondb::server {

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

std::span<const CallRule> CallRules();

// Returns null for an unknown method.
const CallRule* FindCallRule(std::string_view method);

}  // namespace motiondb::server
