// Opens sessions of one PostgreSQL store. After failed attempts it waits, longer each time, so that
// many threads do not hammer a server that starts. Thread-safe.
#pragma once

#include <libpq-fe.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/mutex.h"
#include "storage/postgres/postgres_address.h"

namespace motiondb::storage {

struct CloseSession {
  void operator()(PGconn* session) const { PQfinish(session); }
};
using SessionHandle = std::unique_ptr<PGconn, CloseSession>;

class PostgresConnector {
 public:
  explicit PostgresConnector(PostgresAddress address) : address_(std::move(address)) {}

  // UNAVAILABLE, with reason STORE_UNREACHABLE, if PostgreSQL cannot be reached or refuses the
  // session. After a failed attempt further calls fail at once until a delay is over, which grows
  // from 50 ms to 2 s.
  absl::StatusOr<SessionHandle> Connect();
  // Returns that error.
  absl::Status Unreachable(std::string_view why) const;

  const PostgresAddress& address() const { return address_; }

 private:
  using Clock = std::chrono::steady_clock;

  absl::StatusOr<SessionHandle> TryToConnect() const;

  const PostgresAddress address_;
  Mutex mutex_;
  Clock::duration delay_ ABSL_GUARDED_BY(mutex_){};  // before the next attempt; 0: none failed
  Clock::time_point next_attempt_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace motiondb::storage
