// Errors of PostgreSQL as statuses.
#pragma once

#include <libpq-fe.h>

#include <string_view>

#include "absl/status/status.h"

namespace motiondb::storage {

// Converts the error of a result. `result` null, or without SQLSTATE, or `connection` lost:
// UNAVAILABLE. The message contains PostgreSQL's message and SQLSTATE, and never a value of a row
// or a password.
//   unique_violation -> ALREADY_EXISTS         no space, memory or connections ->
//   RESOURCE_EXHAUSTED data corrupted -> DATA_LOSS                connection, shutdown, read-only
//   -> UNAVAILABLE text with bytes that are no UTF-8, too large -> INVALID_ARGUMENT serialization
//   failure, deadlock -> ABORTED, see IsConflict         any other -> INTERNAL
absl::Status PostgresError(PGconn* connection, const PGresult* result);
// As PostgresError, for the code and the message of an error.
absl::Status PostgresError(std::string_view sqlstate, std::string_view message);

// Returns whether a transaction failed because of a concurrent one: it changed nothing and may
// succeed if it runs again.
bool IsConflict(const absl::Status& error);

}  // namespace motiondb::storage
