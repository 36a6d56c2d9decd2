// A connection to the database engine of a store, and its transactions. The tables (storage/sql)
// are written for this interface, so that every store has the same rows and rules; an engine
// implements it. Only one thread at a time may use a connection.
//
// The SQL of the tables is what SQLite and PostgreSQL have in common, with integers, reals, texts
// (compared by bytes) and blobs.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/error.h"
#include "storage/sql/connection/statement.h"

namespace motiondb::storage {

class Connection {
 public:
  enum class TransactionKind {
    kRead,   // reads a consistent snapshot
    kWrite,  // may change something
  };

  Connection() = default;
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Runs a script of statements without parameters; ignores result rows.
  virtual absl::Status Execute(const std::string& script) = 0;

  // Returns a statement with its parameters bound in order. Each SQL text is prepared once.
  template <typename... Args>
  Statement Query(std::string_view sql, const Args&... args) {
    Statement statement(*this, Prepare(sql));
    (statement.Bind(args), ...);
    return statement;
  }
  // As Query, for a result that may be larger than the memory: rows are read one after another. No
  // other statement may run on the connection before the last row or Reset.
  template <typename... Args>
  Statement Stream(std::string_view sql, const Args&... args) {
    Statement statement(*this, PrepareStream(sql));
    (statement.Bind(args), ...);
    return statement;
  }
  // Returns the first column of the first row. NOT_FOUND if there is no row.
  absl::StatusOr<std::int64_t> QueryInteger(std::string_view sql);

  // Runs an INSERT of one row and returns its value of `key`, the column with the key that the
  // engine chose.
  template <typename... Args>
  absl::StatusOr<std::int64_t> Insert(std::string_view key, std::string_view sql,
                                      const Args&... args) {
    return RunInsert(Query(InsertSql(sql, key), args...));
  }

  // Runs an INSERT of one row into a checked table, and sets its checksum. As Statement::RunLater.
  template <typename... Args>
  absl::Status InsertRow(std::string_view table, std::string_view sql, const Args&... args) {
    return RunInsertRow(table, Query(sql, args...));
  }

  // Returns the number of rows that the last INSERT, UPDATE or DELETE changed.
  virtual int changes() const = 0;

  // See Transaction, which uses them.
  virtual absl::Status BeginTransaction(TransactionKind kind) = 0;
  virtual absl::Status CommitTransaction() = 0;
  // Does nothing if there is no transaction.
  virtual void RollBackTransaction() = 0;
  // Returns whether to run the transaction that failed with `error` again: it changed nothing, and
  // failed because of a concurrent one. `attempts`: so far.
  virtual bool MayRunAgain(const absl::Status& error, int attempts) const = 0;

  // Returns the status of a statement on the table clip_text, marked if the engine can repair what
  // it is about.
  virtual absl::Status OfTexts(const absl::Status& status) const { return status; }
  // Writes the words of changed texts that the engine keeps in memory. A later statement of the
  // transaction would do it, and return its error.
  virtual absl::Status FlushTexts() { return absl::OkStatus(); }

  // Updates the checksum of a row, which its statements changed; nothing if the engine does so.
  // `key`: of the row, in the key column of the table.
  virtual absl::Status SetRowChecksum(std::string_view table, std::int64_t key) = 0;
  // Returns an SQL expression for the checksum of a row with the columns `values`.
  virtual std::string ChecksumOf(std::string_view values) const = 0;

  // Returns an SQL condition: the checksum of a row of a checked table does not match.
  virtual std::string RowIsChanged(std::string_view table) const = 0;

  // Returns up to `count` (at least 1) keys that no row of the table has, until the transaction
  // ends. `key`: the key column.
  virtual absl::StatusOr<std::vector<std::int64_t>> FreeKeys(std::string_view table,
                                                             std::string_view key, int count) = 0;
  // After rows were inserted with given keys: lets the engine choose larger ones.
  virtual absl::Status SkipUsedKeys(std::string_view table, std::string_view key) = 0;

  // Keeps a hidden database, which an import makes, from being purged by other servers for some
  // seconds: in the transaction that inserts it (`is_new`), and in each later one. ABORTED if
  // another server has taken it. Nothing if there is only one server.
  virtual absl::Status KeepHidden(std::int64_t, [[maybe_unused]] bool is_new) {
    return absl::OkStatus();
  }
  // In the transaction that shows it: no longer keeps it. ABORTED as above.
  virtual absl::Status ReleaseHidden(std::int64_t) { return absl::OkStatus(); }
  // Takes a hidden database for a purge. Returns false if another server keeps it.
  virtual absl::StatusOr<bool> TakeHidden(std::int64_t) { return true; }

  // What follows a SELECT of rows that the transaction is going to change, so that transactions on
  // them run one after another. Empty if the engine has only one writer, and in a read transaction.
  virtual std::string_view row_lock() const = 0;
  // Returns how many rows with chunks may be queried at a time.
  virtual std::int64_t max_chunk_rows() const = 0;
  // Returns whether the connection can still be used.
  virtual bool is_usable() const = 0;

 protected:
  // Returns the statement of a text; never null. Errors are those of its first Step.
  virtual std::unique_ptr<PreparedStatement> Prepare(std::string_view sql) = 0;
  virtual std::unique_ptr<PreparedStatement> PrepareStream(std::string_view sql) {
    return Prepare(sql);
  }
  // Takes a statement back, after its Reset.
  virtual void GiveBack(std::unique_ptr<PreparedStatement> statement) = 0;
  // How an INSERT returns its key: the statement to run, and its key after it ran.
  virtual std::string InsertSql(std::string_view sql, std::string_view key) const = 0;
  virtual absl::StatusOr<std::int64_t> RunInsert(Statement statement) = 0;
  virtual absl::Status RunInsertRow(std::string_view table, Statement statement) = 0;

 private:
  friend class Statement;
};

// A transaction. The destructor rolls it back unless it was committed.
class Transaction {
 public:
  using Kind = Connection::TransactionKind;

  // The connection must outlive the transaction; the transaction must outlive its statements.
  static absl::StatusOr<Transaction> Begin(Connection& connection, Kind kind);
  Transaction(Transaction&& other) noexcept;
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();

  // Returns when the changes are durable. After an error nothing was changed, unless the connection
  // says that it does not know.
  absl::Status Commit();

 private:
  explicit Transaction(Connection& connection) : connection_(&connection) {}
  void RollBack();

  Connection* connection_;  // null once moved from
};

inline const absl::Status& StatusOf(const absl::Status& status) { return status; }
template <typename T>
const absl::Status& StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

// Runs work(Connection&), which returns a Status or StatusOr, in a transaction, which is rolled
// back on an error. May run it again if it failed because of a concurrent transaction.
template <typename Work>
auto InTransaction(Connection& connection, Transaction::Kind kind, const Work& work)
    -> std::invoke_result_t<Work, Connection&> {
  using Result = std::invoke_result_t<Work, Connection&>;
  const auto run = [&]() -> Result {
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(connection, kind));
    Result result = work(connection);
    if (!StatusOf(result).ok()) return result;
    MOTIONDB_RETURN_IF_ERROR(transaction.Commit());
    return result;
  };
  for (int attempts = 1;; ++attempts) {
    Result result = run();
    if (StatusOf(result).ok() || !connection.MayRunAgain(StatusOf(result), attempts)) return result;
  }
}

}  // namespace motiondb::storage
