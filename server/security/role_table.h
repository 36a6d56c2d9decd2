// Who may make which call, and what it is to the server: one table, a row for every call of the
// contract. A test walks it against the service definitions, so that none is left out and no row
// outlives its call. Safe to use from any thread.
#pragma once

#include <span>
#include <string_view>

#include "storage/access_store.h"

namespace motiondb::server {

// What a call asks of the server.
enum class CallWeight {
  kLight,         // milliseconds; with a large request it is heavy
  kChange,        // light, but waits for its turn to write: on a thread of its own
  kUrgentChange,  // the same, on a thread that no other change keeps waiting
  kWait,          // takes no thread, and has a timeout of its own
  kHeavy,         // much processor time, memory or disk: goes through a lane of its own
  kStream,        // as long as the client likes, a little at a time
  kUpkeep,        // heavy, and all of the store in one: as long as it takes, on a thread of its own
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
  CallWeight weight;
  Scope scope;
  std::string_view field;  // path in the request, or in the first of a stream: what it is about
  std::string_view collection = {};  // what the field's value is an id in, where it is no full name
};

std::span<const CallRule> CallRules();

// Null if there is none.
const CallRule* FindCallRule(std::string_view method);

}  // namespace motiondb::server
