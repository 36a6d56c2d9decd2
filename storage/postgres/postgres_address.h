// The address of a PostgreSQL store: a URL as libpq takes it, with one parameter more.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::storage {

struct PostgresAddress {
  // For libpq; may contain a password, so it is in no message.
  std::string url;
  // Host, port and database for messages: "postgresql://host:5432/name".
  std::string name;
  // `?pooled=1`: between the server and PostgreSQL is a pooler that gives each transaction another
  // session (pgbouncer with pool_mode=transaction): no prepared statements, nothing that belongs to
  // a session.
  bool pooled = false;
  // Whether a standby is accepted too. The URL can set it: `target_session_attrs`.
  bool read_only = false;
};

// INVALID_ARGUMENT, without the text of the URL, if libpq cannot parse it or `pooled` is neither 0
// nor 1.
absl::StatusOr<PostgresAddress> ParsePostgresUrl(std::string_view url);

}  // namespace motiondb::storage
