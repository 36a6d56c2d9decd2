#include "storage/postgres/postgres_connection.h"

#include <charconv>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "core/motion/error.h"
#include "storage/postgres/postgres_error.h"
#include "storage/postgres/postgres_sql.h"

namespace motiondb::storage {
namespace {

constexpr int kMaxAttempts = 8;            // of a transaction
constexpr int kMinServerVersion = 150000;  // the version that the tests use

// Advisory locks of hidden databases: this number, "hidden" in ASCII, plus the key.
constexpr std::int64_t kHiddenLocks = 0x68696464656e0000;

// Returns whether an error ended the session: one of libpq itself, or a fatal one of PostgreSQL.
// PQstatus can notice it only at the next call.
bool EndsSession(const PGresult* result) {
  const char* const severity = PQresultErrorField(result, PG_DIAG_SEVERITY_NONLOCALIZED);
  return severity == nullptr || std::string_view(severity) == "FATAL" ||
         std::string_view(severity) == "PANIC";
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
  if (!is_usable()) return connector_->Unreachable(std::string(error.message()));
  return error;
}

absl::StatusOr<std::string> PostgresConnection::Command(const char* sql) {
  MOTIONDB_ASSIGN_OR_RETURN(const ResultHandle result, Finish(PQexec(handle_.get(), sql)));
  return std::string(PQcmdStatus(result.get()));
}

absl::Status PostgresConnection::Execute(const std::string& script) {
  return Command(script.c_str()).status();
}

absl::Status PostgresConnection::BeginTransaction(TransactionKind kind) {
  const bool writes = kind == TransactionKind::kWrite;
  const char* const begin = writes ? "BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE"
                                   : "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY";
  is_writing_ = writes;
  if (is_usable()) {
    // A session that ended since its last use fails here, before anything was done.
    const auto begun = Command(begin);
    if (begun.ok() || is_usable()) return begun.status();
  }
  MOTIONDB_RETURN_IF_ERROR(Reconnect());
  return Command(begin).status();
}

absl::Status PostgresConnection::CommitTransaction() {
  MOTIONDB_ASSIGN_OR_RETURN(const std::string tag, Command("COMMIT"));
  // Of a transaction in which a statement failed, PostgreSQL answers with ROLLBACK.
  if (tag != "COMMIT") return absl::InternalError("PostgreSQL: the transaction was rolled back");
  return absl::OkStatus();
}

void PostgresConnection::RollBackTransaction() {
  if (PQtransactionStatus(handle_.get()) == PQTRANS_IDLE || !is_usable()) return;
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
  const auto& types = statement.parameters().types;
  std::string key = statement.sql();
  for (const Oid type : types) key += fmt::format(",{}", type);
  const auto known = prepared_.find(key);
  if (known != prepared_.end()) return known->second;
  std::string name = fmt::format("s{}", prepared_.size());
  MOTIONDB_RETURN_IF_ERROR(Finish(PQprepare(handle_.get(), name.c_str(), statement.sql().c_str(),
                                            static_cast<int>(types.size()), types.data()))
                               .status());
  prepared_.emplace(std::move(key), name);
  return name;
}

absl::StatusOr<ResultHandle> PostgresConnection::Run(const PostgresStatement& statement) {
  const PostgresParameters& parameters = statement.parameters();
  const auto count = static_cast<int>(parameters.types.size());
  PGresult* result = nullptr;
  if (connector_->address().pooled) {
    result = PQexecParams(handle_.get(), statement.sql().c_str(), count, parameters.types.data(),
                          parameters.values.data(), parameters.lengths.data(),
                          parameters.formats.data(), /*resultFormat=*/1);
  } else {
    MOTIONDB_ASSIGN_OR_RETURN(const std::string name, NameOf(statement));
    result = PQexecPrepared(handle_.get(), name.c_str(), count, parameters.values.data(),
                            parameters.lengths.data(), parameters.formats.data(),
                            /*resultFormat=*/1);
  }
  MOTIONDB_ASSIGN_OR_RETURN(ResultHandle finished, Finish(result));
  const std::string_view tag = PQcmdStatus(finished.get());
  if (!tag.starts_with("SELECT")) {
    const char* const changed = PQcmdTuples(finished.get());
    changes_ = 0;
    std::from_chars(changed, changed + std::strlen(changed), changes_);
  }
  return finished;
}

absl::Status PostgresConnection::Send(const PostgresStatement& statement) {
  const PostgresParameters& parameters = statement.parameters();
  const int sent = PQsendQueryParams(
      handle_.get(), statement.sql().c_str(), static_cast<int>(parameters.types.size()),
      parameters.types.data(), parameters.values.data(), parameters.lengths.data(),
      parameters.formats.data(), /*resultFormat=*/1);
  if (sent != 0 && PQsetSingleRowMode(handle_.get()) != 0) return absl::OkStatus();
  return Finish(nullptr).status();
}

absl::StatusOr<ResultHandle> PostgresConnection::NextRow() {
  auto result = Finish(PQgetResult(handle_.get()));
  const bool is_last = !result.ok() || PQresultStatus(result->get()) != PGRES_SINGLE_TUPLE;
  // After the last result, libpq has a null.
  while (is_last && is_usable()) {
    const ResultHandle rest(PQgetResult(handle_.get()));
    if (rest == nullptr) break;
  }
  return result;
}

void PostgresConnection::StopRows() {
  char error[256];
  PGcancel* const cancel = PQgetCancel(handle_.get());
  PQcancel(cancel, error, sizeof(error));
  PQfreeCancel(cancel);
  while (true) {
    const ResultHandle rest(PQgetResult(handle_.get()));
    if (rest == nullptr) return;
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

absl::Status PostgresConnection::KeepHidden(std::int64_t database_key) {
  if (connector_->address().pooled) return absl::OkStatus();
  return Query("SELECT pg_advisory_lock(?)", kHiddenLocks + database_key).Run();
}

absl::Status PostgresConnection::ReleaseHidden(std::int64_t database_key) {
  if (connector_->address().pooled) return absl::OkStatus();
  return Query("SELECT pg_advisory_unlock(?)", kHiddenLocks + database_key).Run();
}

std::string_view PostgresConnection::IsNotKept() const {
  static const std::string kCondition =
      fmt::format("pg_try_advisory_xact_lock({} + database_key)", kHiddenLocks);
  return kCondition;
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

}  // namespace motiondb::storage
