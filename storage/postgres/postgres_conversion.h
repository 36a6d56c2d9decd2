// Conversions between the tables and PostgreSQL: of SQL, texts and errors.
#pragma once

#include <libpq-fe.h>

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace motiondb::storage {

// Translates the SQL of the tables to PostgreSQL's: `?` and `?3` become `$1` and `$3`. As in
// SQLite, `?` has the number after the largest one so far. Texts in quotes stay.
std::string ToPostgresSql(std::string_view sql);

// Returns any bytes as a text of PostgreSQL, which takes neither NUL nor invalid UTF-8. A store
// accepts any string, so these are escaped; the order of valid texts stays that of their bytes.
// NUL becomes "\x01" "0", "\x01" becomes "\x01" "1", and a byte that is not part of valid UTF-8
// "\x01" "2" and two hexadecimal digits. Other texts stay.
std::string ToPostgresText(std::string_view bytes);
// Reverses ToPostgresText.
std::string FromPostgresText(std::string_view text);

// Converts the error of a result. `result` null, or without SQLSTATE, or `connection` lost:
// UNAVAILABLE. The message contains PostgreSQL's message and SQLSTATE, and never a value of a row
// or a password.
//   unique_violation -> ALREADY_EXISTS       no space, memory or connections -> RESOURCE_EXHAUSTED
//   data corrupted -> DATA_LOSS              connection, shutdown, read-only -> UNAVAILABLE
//   text with bytes that are no UTF-8, too large -> INVALID_ARGUMENT
//   serialization failure, deadlock -> ABORTED, see IsConflict
//   any other -> INTERNAL
absl::Status PostgresError(PGconn* connection, const PGresult* result);
// As PostgresError, for the code and the message of an error.
absl::Status PostgresError(std::string_view sqlstate, std::string_view message);

// Returns whether a transaction failed because of a concurrent one: it changed nothing and may
// succeed if it runs again.
bool IsConflict(const absl::Status& error);

}  // namespace motiondb::storage
