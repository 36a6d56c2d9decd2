// A session of PostgreSQL, with named prepared statements. Only one thread at a time may use it.
//
// Calls wait for PostgreSQL: they run on threads of the store, never on one that serves
// connections. They wait in one place, PostgresConnector::Await. A read that is cancelled, or whose
// PostgreSQL hangs, gives up its session.
//
// A statement whose result is not used waits in a queue, the pipeline mode of libpq, until the
// next one is sent. So a clip waits 12 times for the network instead of 19 times, a model of 100
// clips 185 times instead of 315, and the migration of 200 clips 172 times instead of 1,807. COPY
// would save no more: chunks take the same time, and 1,000 rows without chunks 10 ms instead of 27
// ms.
#pragma once

#include <libpq-fe.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/postgres/postgres_connector.h"
#include "storage/postgres/postgres_statement.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

class PostgresConnection final : public Connection {
 public:
  // The errors of PostgresConnector.
  static absl::StatusOr<std::unique_ptr<PostgresConnection>> Open(
      std::shared_ptr<PostgresConnector> connector);

  absl::Status Execute(const std::string& script) override;
  int changes() const override { return changes_; }

  // Connects again if the session was lost: the errors of PostgresConnector.
  absl::Status BeginTransaction(TransactionKind kind) override;
  // UNAVAILABLE if the session was lost meanwhile: it is then unknown whether the changes were
  // made.
  absl::Status CommitTransaction() override;
  void RollBackTransaction() override;
  // Waits a few milliseconds before it returns true.
  bool MayRunAgain(const absl::Status& error, int attempts) const override;

  // Triggers set the checksums (migrations.cc).
  absl::Status SetRowChecksum(std::string_view, std::int64_t) override { return absl::OkStatus(); }
  std::string ChecksumOf(std::string_view) const override { return "NULL"; }

  std::string RowIsChanged(std::string_view table) const override;
  absl::StatusOr<std::vector<std::int64_t>> FreeKeys(std::string_view table, std::string_view key,
                                                     int count) override;
  absl::Status SkipUsedKeys(std::string_view table, std::string_view key) override;

  // The import has the build lease of the database, for 30 s. A lock of the session would end with
  // a lost connection, and poolers have none.
  absl::Status KeepHidden(std::int64_t database_key, bool is_new) override;
  absl::Status ReleaseHidden(std::int64_t database_key) override;
  absl::StatusOr<bool> TakeHidden(std::int64_t database_key) override;

  std::string_view row_lock() const override { return is_writing_ ? " FOR NO KEY UPDATE" : ""; }
  // A statement has all its rows in memory.
  std::int64_t max_chunk_rows() const override { return 16; }
  bool is_usable() const override { return !is_lost_ && PQstatus(handle_.get()) == CONNECTION_OK; }

  // Runs a statement with its parameters, after those in the queue. The error of one of these is
  // that of the call.
  absl::StatusOr<ResultHandle> Run(const PostgresStatement& statement);
  // Puts a statement of a write transaction into the queue. Returns false in a read transaction.
  absl::StatusOr<bool> Queue(const PostgresStatement& statement);

  // Sends a statement; NextRow then returns its rows one after another (PGRES_SINGLE_TUPLE), last a
  // result without rows. StopRows ends it before that.
  absl::Status Send(const PostgresStatement& statement);
  absl::StatusOr<ResultHandle> NextRow();
  void StopRows();

  // As PQserverVersion: 150003 is 15.3.
  int server_version() const { return PQserverVersion(handle_.get()); }
  // Host, port and database of the session, also if they come from variables or a service file:
  // "postgresql://host:5432/name".
  std::string place() const;
  // Process id of PostgreSQL's side of the session.
  int backend_pid() const { return PQbackendPID(handle_.get()); }

 protected:
  std::unique_ptr<PreparedStatement> Prepare(std::string_view sql) override;
  std::unique_ptr<PreparedStatement> PrepareStream(std::string_view sql) override;
  void GiveBack(std::unique_ptr<PreparedStatement>) override {}
  std::string InsertSql(std::string_view sql, std::string_view key) const override;
  absl::StatusOr<std::int64_t> RunInsert(Statement statement) override;
  absl::Status RunInsertRow(std::string_view, Statement statement) override {
    return statement.RunLater();
  }

 private:
  PostgresConnection(std::shared_ptr<PostgresConnector> connector, SessionHandle session)
      : connector_(std::move(connector)), handle_(std::move(session)) {}
  absl::Status Reconnect();
  // Runs one statement without parameters; returns its command tag, as in "COMMIT".
  absl::StatusOr<std::string> Command(const char* sql);
  const std::string& Translated(std::string_view sql);
  // Returns the result that a call of libpq waited for, or its error.
  absl::StatusOr<ResultHandle> Finish(PGresult* result);
  // As PostgresConnector::Await. After an error the session is lost.
  absl::Status Await(PostgresConnector::Awaited awaited);
  // Returns the next result, also null, of what was sent.
  absl::StatusOr<ResultHandle> Receive();
  // Returns the last result, or the error, of what was sent outside the pipeline mode. `sent` is
  // the value of the sending call of libpq.
  absl::StatusOr<ResultHandle> ReceiveAll(int sent);
  // Returns the name of the prepared statement for this text and these types; empty with a pooler.
  absl::StatusOr<std::string> NameOf(const PostgresStatement& statement);
  // Sends a statement without waiting for its result, in the pipeline mode of libpq.
  absl::Status SendToQueue(const PostgresStatement& statement);
  // Waits for the queue. Returns the result of the last statement, or the first error; null if
  // there is none.
  absl::StatusOr<ResultHandle> Collect();

  const std::shared_ptr<PostgresConnector> connector_;
  SessionHandle handle_;
  bool is_lost_ = false;  // an error ended the session
  bool is_writing_ = false;
  int changes_ = 0;
  int queued_ = 0;  // statements that were sent and whose results were not read
  std::unordered_map<std::string, std::string> translated_;  // SQL by the tables' SQL
  std::unordered_map<std::string, std::string> prepared_;    // names by SQL and types
};

// FAILED_PRECONDITION if the version of PostgreSQL is not supported.
absl::Status CheckServerVersion(const PostgresConnection& connection);

// Returns whether a server keeps a hidden database (Connection::KeepHidden): it imports one.
absl::StatusOr<bool> HasHidden(Connection& connection);

}  // namespace motiondb::storage
