// The address of a PostgreSQL store, and the sessions with it.
#pragma once

#include <libpq-fe.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"
#include "storage/mutex.h"

namespace motiondb::storage {

// The address of a store, parsed from a URL.
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

// `url`: as libpq takes it, with the parameter `pooled` in addition. INVALID_ARGUMENT, without the
// text of the URL, if libpq cannot parse it or `pooled` is neither 0 nor 1.
absl::StatusOr<PostgresAddress> ParsePostgresUrl(std::string_view url);

struct CloseSession {
  void operator()(PGconn* session) const { PQfinish(session); }
};
using SessionHandle = std::unique_ptr<PGconn, CloseSession>;

// Opens sessions of one PostgreSQL store. After failed attempts it waits, longer each time, so that
// many threads do not hammer a server that starts. Thread-safe.
class PostgresConnector {
 public:
  explicit PostgresConnector(PostgresAddress address);

  // UNAVAILABLE, with reason STORE_UNREACHABLE, if PostgreSQL cannot be reached or refuses the
  // session. After a failed attempt further calls fail immediately until a delay is over, which
  // grows from 50 ms to 2 s, and while another thread makes the next attempt. Sessions do not block
  // (PQsetnonblocking): use Await.
  absl::StatusOr<SessionHandle> Connect();

  // Sends what is left to send; with kResult also waits until PQgetResult returns without waiting.
  // UNAVAILABLE, with reason STORE_UNREACHABLE, if PostgreSQL hangs: it sends nothing for 5 s, and
  // then does not respond to a new connection. CANCELLED if `cancelled` returns true after a second
  // without data. After an error the session cannot be used.
  enum class Awaited { kSent, kResult };
  absl::Status Await(PGconn* session, const core::Cancelled& cancelled,
                     Awaited awaited = Awaited::kResult);
  // Returns whether the server of a session responds to a new connection within 5 s. If not,
  // `hangs` is true until Connect succeeds.
  bool Responds(const PGconn* session);
  bool hangs() const { return hangs_; }
  // Returns whether PostgreSQL responds and refuses every session of this URL, also on a standby:
  // the password, the role or the database is wrong. False with a pooler, which can respond while
  // PostgreSQL is gone.
  bool IsRefused() const;

  // Returns that error.
  absl::Status Unreachable(std::string_view why) const;

  const PostgresAddress& address() const { return address_; }
  // Of the imports of this store, among those of all servers: "import/1a2b3c4d5e6f7081".
  const std::string& importer() const { return importer_; }
  std::int64_t opened() const { return opened_; }  // sessions
  std::int64_t failed() const { return failed_; }  // attempts to open one

 private:
  using Clock = std::chrono::steady_clock;

  // `attributes`: the default of target_session_attrs.
  absl::StatusOr<SessionHandle> TryToConnect(const char* attributes) const;

  const PostgresAddress address_;
  const std::string importer_;
  std::atomic<std::int64_t> opened_{0};
  std::atomic<std::int64_t> failed_{0};
  std::atomic<bool> hangs_{false};
  Mutex mutex_;
  Clock::duration delay_ ABSL_GUARDED_BY(mutex_){};  // before the next attempt; 0: none failed
  Clock::time_point next_attempt_ ABSL_GUARDED_BY(mutex_);
  bool is_connecting_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace motiondb::storage
