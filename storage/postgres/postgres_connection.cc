#include "storage/postgres/postgres_connection.h"

#include <charconv>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_conversion.h"
#include "storage/thread_scopes.h"

namespace motiondb::storage {
namespace {

constexpr int kMaxAttempts = 8;            // of a transaction
constexpr int kMinServerVersion = 150000;  // the version that the tests use
constexpr int kMaxQueued = 256;            // so that their results are few

// Bounds how long a server that is stopped or cut off can block the others, which wait for the row
// of its database: PostgreSQL ends its session after 10 s without a statement. Nothing computes for
// seconds in a write transaction. A read transaction may: it blocks no other one. The limit of the
// wait for one lock is longer, so that the others then continue. In the transaction, because of
// poolers.
constexpr char kBeginWrite[] =
    "BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE; "
    "SET LOCAL idle_in_transaction_session_timeout = '10s'; SET LOCAL lock_timeout = '15s'";
constexpr char kBeginRead[] = "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";

constexpr std::string_view kNowUs = "(extract(epoch FROM clock_timestamp()) * 1000000)::bigint";

absl::Status ImportRemoved() {
  return absl::AbortedError(
      "another server has removed the import, which stood still for 30 s: import the file again");
}

// Returns whether an error ended the session: one of libpq itself, or a fatal one of PostgreSQL.
// PQstatus can notice it only at the next call. A session of a standby is of no use (0A000 from
// BEGIN READ WRITE): the primary has moved.
bool EndsSession(const PGresult* result) {
  const char* const severity = PQresultErrorField(result, PG_DIAG_SEVERITY_NONLOCALIZED);
  const char* const sqlstate = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  return severity == nullptr || std::string_view(severity) == "FATAL" ||
         std::string_view(severity) == "PANIC" ||
         (sqlstate != nullptr && std::string_view(sqlstate) == "0A000");
}

}  // namespace

absl::StatusOr<std::unique_ptr<PostgresConnection>> PostgresConnection::Open(
    std::shared_ptr<PostgresConnector> connector) {
  MOTIONDB_ASSIGN_OR_RETURN(SessionHandle session, connector->Connect());
  return std::unique_ptr<PostgresConnection>(
      new PostgresConnection(std::move(connector), std::move(session)));
}

absl::Status PostgresConnection::Reconnect() {
  MOTIONDB_ASSIGN_OR_RETURN(handle_, connector_->Connect());
  prepared_.clear();
  queued_ = 0;
  is_lost_ = false;
  return absl::OkStatus();
}

absl::StatusOr<ResultHandle> PostgresConnection::Finish(PGresult* result) {
  ResultHandle finished(result);
  const ExecStatusType status = PQresultStatus(finished.get());
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_SINGLE_TUPLE) {
    return finished;
  }
  absl::Status error = PostgresError(handle_.get(), finished.get());
  if (EndsSession(finished.get())) is_lost_ = true;
  // Also if the session remains, as after lock_timeout: the caller retries.
  const bool is_gone = !is_usable() || absl::IsUnavailable(error);
  return is_gone ? connector_->Unreachable(std::string(error.message())) : error;
}

absl::Status PostgresConnection::Await(PostgresConnector::Awaited awaited) {
  const core::Cancelled cancelled = is_writing_ ? core::Cancelled() : ReadScope::cancelled();
  absl::Status arrived = connector_->Await(handle_.get(), cancelled, awaited);
  if (!arrived.ok()) is_lost_ = true;
  return arrived;
}

absl::StatusOr<ResultHandle> PostgresConnection::Receive() {
  MOTIONDB_RETURN_IF_ERROR(Await(PostgresConnector::Awaited::kResult));
  return ResultHandle(PQgetResult(handle_.get()));
}

absl::StatusOr<ResultHandle> PostgresConnection::ReceiveAll(int sent) {
  if (sent == 0) return Finish(nullptr);
  ResultHandle last;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(ResultHandle result, Receive());
    if (result == nullptr) return Finish(last.release());
    last = std::move(result);
  }
}

absl::StatusOr<std::string> PostgresConnection::Command(const char* sql) {
  MOTIONDB_RETURN_IF_ERROR(Collect().status());
  MOTIONDB_ASSIGN_OR_RETURN(const ResultHandle result, ReceiveAll(PQsendQuery(handle_.get(), sql)));
  return std::string(PQcmdStatus(result.get()));
}

absl::Status PostgresConnection::Execute(const std::string& script) {
  return Command(script.c_str()).status();
}

absl::Status PostgresConnection::BeginTransaction(TransactionKind kind) {
  is_writing_ = kind == TransactionKind::kWrite;
  const char* const begin = is_writing_ ? kBeginWrite : kBeginRead;
  if (is_usable() && !connector_->hangs()) {
    // A session that ended since its last use fails here, before anything was done.
    const auto begun = Command(begin);
    if (begun.ok() || is_usable() || absl::IsCancelled(begun.status())) return begun.status();
  }
  MOTIONDB_RETURN_IF_ERROR(Reconnect());
  return Command(begin).status();
}

absl::Status PostgresConnection::CommitTransaction() {
  const PostgresStatement commit(*this, "COMMIT", PostgresStatement::Rows::kAll);
  MOTIONDB_RETURN_IF_ERROR(SendToQueue(commit));
  MOTIONDB_ASSIGN_OR_RETURN(const ResultHandle result, Collect());
  const std::string_view tag = PQcmdStatus(result.get());
  // Of a transaction in which a statement failed, PostgreSQL answers with ROLLBACK.
  if (tag != "COMMIT") return absl::InternalError("PostgreSQL: the transaction was rolled back");
  return absl::OkStatus();
}

void PostgresConnection::RollBackTransaction() {
  if (PQtransactionStatus(handle_.get()) == PQTRANS_IDLE || !is_usable()) return;
  Collect().status().IgnoreError();
  Command("ROLLBACK").status().IgnoreError();
}

bool PostgresConnection::MayRunAgain(const absl::Status& error, int attempts) const {
  if (!IsConflict(error) || attempts >= kMaxAttempts) return false;
  std::this_thread::sleep_for(std::chrono::milliseconds(2 * attempts));
  return true;
}

const std::string& PostgresConnection::Translated(std::string_view sql) {
  const auto [known, is_new] = translated_.try_emplace(std::string(sql));
  if (is_new) known->second = ToPostgresSql(sql);
  return known->second;
}

std::string PostgresConnection::place() const {
  return fmt::format("postgresql://{}:{}/{}", PQhost(handle_.get()), PQport(handle_.get()),
                     PQdb(handle_.get()));
}

std::unique_ptr<PreparedStatement> PostgresConnection::Prepare(std::string_view sql) {
  return std::make_unique<PostgresStatement>(*this, Translated(sql), PostgresStatement::Rows::kAll);
}

std::unique_ptr<PreparedStatement> PostgresConnection::PrepareStream(std::string_view sql) {
  return std::make_unique<PostgresStatement>(*this, Translated(sql),
                                             PostgresStatement::Rows::kStream);
}

absl::StatusOr<std::string> PostgresConnection::NameOf(const PostgresStatement& statement) {
  if (connector_->address().pooled) return std::string();
  const auto& types = statement.parameters().types;
  std::string key = statement.sql();
  for (const Oid type : types) key += fmt::format(",{}", type);
  const auto known = prepared_.find(key);
  if (known != prepared_.end()) return known->second;
  MOTIONDB_RETURN_IF_ERROR(Collect().status());
  std::string name = fmt::format("s{}", prepared_.size());
  MOTIONDB_RETURN_IF_ERROR(
      ReceiveAll(PQsendPrepare(handle_.get(), name.c_str(), statement.sql().c_str(),
                               static_cast<int>(types.size()), types.data()))
          .status());
  prepared_.emplace(std::move(key), name);
  return name;
}

absl::Status PostgresConnection::SendToQueue(const PostgresStatement& statement) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string name, NameOf(statement));
  const PostgresParameters& parameters = statement.parameters();
  const auto count = static_cast<int>(parameters.types.size());
  if (PQenterPipelineMode(handle_.get()) == 0) return Finish(nullptr).status();
  const int sent =
      name.empty()
          ? PQsendQueryParams(handle_.get(), statement.sql().c_str(), count,
                              parameters.types.data(), parameters.values.data(),
                              parameters.lengths.data(), parameters.formats.data(),
                              /*resultFormat=*/1)
          : PQsendQueryPrepared(handle_.get(), name.c_str(), count, parameters.values.data(),
                                parameters.lengths.data(), parameters.formats.data(),
                                /*resultFormat=*/1);
  // Each has its synchronization and is sent completely: otherwise PostgreSQL would not count the
  // time until the next statement as idle, and a server that stops here would keep its locks.
  if (sent == 0 || PQpipelineSync(handle_.get()) == 0) return Finish(nullptr).status();
  ++queued_;
  return Await(PostgresConnector::Awaited::kSent);
}

absl::StatusOr<ResultHandle> PostgresConnection::Collect() {
  absl::StatusOr<ResultHandle> last = ResultHandle();
  if (queued_ == 0) return last;
  for (; queued_ > 0 && is_usable(); --queued_) {
    MOTIONDB_ASSIGN_OR_RETURN(ResultHandle result, Receive());
    // After an error PostgreSQL refuses the other statements.
    if (last.ok()) last = Finish(result.release());
    // Null, the end of the statement, and its synchronization.
    for (int rest = 0; rest < 2 && is_usable(); ++rest) {
      MOTIONDB_RETURN_IF_ERROR(Receive().status());
    }
  }
  if (!is_usable()) return last;
  PQexitPipelineMode(handle_.get());
  return last;
}

absl::StatusOr<bool> PostgresConnection::Queue(const PostgresStatement& statement) {
  if (!is_writing_) return false;
  MOTIONDB_RETURN_IF_ERROR(SendToQueue(statement));
  if (queued_ >= kMaxQueued) MOTIONDB_RETURN_IF_ERROR(Collect().status());
  return true;
}

absl::StatusOr<ResultHandle> PostgresConnection::Run(const PostgresStatement& statement) {
  MOTIONDB_RETURN_IF_ERROR(SendToQueue(statement));
  MOTIONDB_ASSIGN_OR_RETURN(ResultHandle finished, Collect());
  const std::string_view tag = PQcmdStatus(finished.get());
  if (!tag.starts_with("SELECT")) {
    const char* const changed = PQcmdTuples(finished.get());
    changes_ = 0;
    std::from_chars(changed, changed + std::strlen(changed), changes_);
  }
  return finished;
}

absl::Status PostgresConnection::Send(const PostgresStatement& statement) {
  MOTIONDB_RETURN_IF_ERROR(Collect().status());
  const PostgresParameters& parameters = statement.parameters();
  const int sent = PQsendQueryParams(
      handle_.get(), statement.sql().c_str(), static_cast<int>(parameters.types.size()),
      parameters.types.data(), parameters.values.data(), parameters.lengths.data(),
      parameters.formats.data(), /*resultFormat=*/1);
  if (sent != 0 && PQsetSingleRowMode(handle_.get()) != 0) return absl::OkStatus();
  return Finish(nullptr).status();
}

absl::StatusOr<ResultHandle> PostgresConnection::NextRow() {
  MOTIONDB_ASSIGN_OR_RETURN(ResultHandle received, Receive());
  auto result = Finish(received.release());
  const bool is_last = !result.ok() || PQresultStatus(result->get()) != PGRES_SINGLE_TUPLE;
  // After the last result, libpq has a null.
  while (is_last && is_usable()) {
    MOTIONDB_ASSIGN_OR_RETURN(const ResultHandle rest, Receive());
    if (rest == nullptr) break;
  }
  return result;
}

void PostgresConnection::StopRows() {
  // PQcancel waits without limit.
  if (!is_usable() || !connector_->Responds(handle_.get())) {
    is_lost_ = true;
    return;
  }
  char error[256];
  PGcancel* const cancel = PQgetCancel(handle_.get());
  PQcancel(cancel, error, sizeof(error));
  PQfreeCancel(cancel);
  while (true) {
    const auto rest = Receive();
    if (!rest.ok() || *rest == nullptr) return;
  }
}

std::string PostgresConnection::RowIsChanged(std::string_view table) const {
  return fmt::format("row_crc IS DISTINCT FROM motiondb_row_crc({})", table);
}

absl::StatusOr<std::vector<std::int64_t>> PostgresConnection::FreeKeys(std::string_view table,
                                                                       std::string_view key,
                                                                       int count) {
  Statement row =
      Query("SELECT nextval(pg_get_serial_sequence(?, ?)::regclass) FROM generate_series(1, ?)",
            table, key, count);
  std::vector<std::int64_t> keys;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return keys;
    keys.push_back(row.Integer(0));
  }
}

absl::Status PostgresConnection::SkipUsedKeys(std::string_view table, std::string_view key) {
  const std::string sequence =
      fmt::format("pg_get_serial_sequence('{}', '{}')::regclass", table, key);
  return Query(fmt::format("SELECT setval({0}, greatest(nextval({0}), max({1}))) FROM {2}",
                           sequence, key, table))
      .Run();
}

absl::Status PostgresConnection::KeepHidden(std::int64_t database_key, bool is_new) {
  const char* const sql =
      is_new ? "INSERT INTO build_lease (database_key, holder, fence, expire_time_us) "
               "VALUES (?, ?, 0, {} + 30000000)"
             : "UPDATE build_lease SET expire_time_us = {} + 30000000 "
               "WHERE database_key = ? AND holder = ?";
  MOTIONDB_RETURN_IF_ERROR(
      Query(fmt::format(fmt::runtime(sql), kNowUs), database_key, connector_->importer()).Run());
  return changes_ == 1 ? absl::OkStatus() : ImportRemoved();
}

absl::Status PostgresConnection::ReleaseHidden(std::int64_t database_key) {
  MOTIONDB_RETURN_IF_ERROR(Query("DELETE FROM build_lease WHERE database_key = ? AND holder = ?",
                                 database_key, connector_->importer())
                               .Run());
  return changes_ == 1 ? absl::OkStatus() : ImportRemoved();
}

absl::StatusOr<bool> PostgresConnection::TakeHidden(std::int64_t database_key) {
  MOTIONDB_RETURN_IF_ERROR(Query(fmt::format("DELETE FROM build_lease WHERE database_key = ? AND "
                                             "(holder = ? OR expire_time_us <= {})",
                                             kNowUs),
                                 database_key, connector_->importer())
                               .Run());
  Statement kept = Query(
      "SELECT 1 FROM build_lease WHERE database_key = ? AND holder LIKE 'import/%'", database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, kept.Step());
  return !found;
}

std::string PostgresConnection::InsertSql(std::string_view sql, std::string_view key) const {
  return fmt::format("{} RETURNING {}", sql, key);
}

absl::StatusOr<std::int64_t> PostgresConnection::RunInsert(Statement statement) {
  MOTIONDB_ASSIGN_OR_RETURN(const bool row, statement.Step());
  if (!row) return absl::InternalError("PostgreSQL: an INSERT returned no key");
  return statement.Integer(0);
}

absl::Status CheckServerVersion(const PostgresConnection& connection) {
  if (connection.server_version() >= kMinServerVersion) return absl::OkStatus();
  return core::FailedPrecondition("motiondb needs PostgreSQL {} or newer; the server has {}.{}",
                                  kMinServerVersion / 10000, connection.server_version() / 10000,
                                  connection.server_version() % 10000);
}

absl::StatusOr<bool> HasHidden(Connection& connection) {
  Statement kept = connection.Query(fmt::format(
      "SELECT 1 FROM build_lease WHERE holder LIKE 'import/%' AND expire_time_us > {}", kNowUs));
  return kept.Step();
}

}  // namespace motiondb::storage
