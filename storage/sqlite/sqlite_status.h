// SQLite's result codes as statuses: the one table.
#pragma once

#include <sqlite3.h>

#include "absl/status/status.h"

namespace motiondb::storage {

// `code` is a result code, extended or not, other than OK, ROW and DONE. The message names the file
// and says what SQLite says.
//   CORRUPT, NOTADB -> DATA_LOSS             FULL, NOMEM -> RESOURCE_EXHAUSTED
//   IOERR, BUSY, LOCKED, CANTOPEN, PROTOCOL -> UNAVAILABLE
//   a UNIQUE or PRIMARY KEY constraint -> ALREADY_EXISTS
//   READONLY, PERM, AUTH -> PERMISSION_DENIED   TOOBIG -> INVALID_ARGUMENT   any other -> INTERNAL
absl::Status SqliteError(sqlite3* database, int code);

}  // namespace motiondb::storage
