#include "storage/migration/migrate_store.h"

#include <algorithm>
#include <vector>

#include "core/motion/error.h"
#include "storage/migration/migration_end.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/row_copy.h"
#include "storage/sql/tables/table_lists.h"

namespace motiondb::storage {
namespace {

// Returns the rows of a table in order, with a last column: whether the checksum is wrong.
Statement RowsOf(Connection& connection, const CopiedTable& table) {
  const std::string changed =
      table.has_checksum() ? connection.RowIsChanged(table.name) : std::string("FALSE");
  return connection.Stream(fmt::format("SELECT {}, {} FROM {} ORDER BY {}", ColumnNames(table),
                                       changed, table.name, table.keys));
}

bool IsSame(const Statement& a, const Statement& b, int column) {
  if (a.Type(column) != b.Type(column)) return false;
  switch (a.Type(column)) {
    case ColumnType::kNull:
      return true;
    case ColumnType::kInteger:
      return a.Integer(column) == b.Integer(column);
    case ColumnType::kReal:
      return a.Real(column) == b.Real(column);  // -0 is 0: SQLite does not store the sign
    case ColumnType::kText:
      return a.Text(column) == b.Text(column);
    case ColumnType::kBlob:
      return std::ranges::equal(a.Blob(column), b.Blob(column));
  }
  return false;
}

class TableComparison {
 public:
  TableComparison(Connection& source, Connection& copy, const CopiedTable& table)
      : table_(table),
        columns_(ColumnsOf(table)),
        source_(RowsOf(source, table)),
        copy_(RowsOf(copy, table)) {}

  // Compares the next row; adds the bytes of its blobs. Returns false after the last one.
  absl::StatusOr<bool> Step(std::int64_t& bytes) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool has_row, source_.Step());
    MOTIONDB_ASSIGN_OR_RETURN(const bool copy_has_row, copy_.Step());
    if (!has_row && !copy_has_row) return false;
    if (has_row != copy_has_row) {
      return Differs(has_row ? source_ : copy_,
                     has_row ? "is missing in the copy" : "is only in the copy");
    }
    const auto count = static_cast<int>(columns_.size());
    for (int c = 0; c < count; ++c) {
      if (!IsSame(source_, copy_, c)) {
        return Differs(source_,
                       fmt::format("'{}' differs", columns_[static_cast<std::size_t>(c)].name));
      }
      if (source_.IsBlob(c)) bytes += std::ssize(source_.Blob(c));
    }
    if (copy_.Integer(count) != 0) return Differs(copy_, "the checksum of the copy does not match");
    return true;
  }

 private:
  absl::Status Differs(const Statement& row, std::string_view how) const {
    return core::DataLoss("table {}, row {}: {}", table_.name, row.Integer(0), how);
  }

  const CopiedTable& table_;
  const std::vector<CopiedColumn> columns_;
  Statement source_;
  Statement copy_;
};

// Compares all rows of two stores of any engines, bit by bit: every column of every row, the search
// texts included, and the checksums of the rows of `copy`. DATA_LOSS names the first row that
// differs. `on_bytes` gets the bytes of blobs compared so far. In the caller's read transactions.
// CANCELLED.
absl::Status CompareStores(Connection& source, Connection& copy,
                           const std::function<void(std::int64_t bytes)>& on_bytes,
                           const core::Cancelled& cancelled) {
  constexpr std::int64_t kPollRows = 64;
  std::vector<CopiedTable> tables = TablesOfStore();
  tables.push_back(TextTable());
  std::int64_t bytes = 0;
  std::int64_t rows = 0;
  for (const CopiedTable& table : tables) {
    TableComparison comparison(source, copy, table);
    for (bool more = true; more; ++rows) {
      if (rows % kPollRows == 0) {
        if (cancelled && cancelled()) {
          return absl::CancelledError("cancelled while the stores were compared");
        }
        if (on_bytes) on_bytes(bytes);
      }
      MOTIONDB_ASSIGN_OR_RETURN(more, comparison.Step(bytes));
    }
  }
  return absl::OkStatus();
}

using Phase = MigrationProgress::Phase;

class Migration {
 public:
  Migration(MigrationEnd& source, MigrationEnd& target,
            const std::function<void(const MigrationProgress&)>& on_progress,
            const core::Cancelled& cancelled)
      : source_(source), target_(target), on_progress_(on_progress), cancelled_(cancelled) {
    progress_.is_continued = target.is_continued();
  }

  absl::Status Run() {
    {
      // One snapshot for the copy and the comparison.
      MOTIONDB_ASSIGN_OR_RETURN(const Transaction snapshot,
                                Transaction::Begin(source_.connection(), Transaction::Kind::kRead));
      MOTIONDB_RETURN_IF_ERROR(Copy());
      MOTIONDB_RETURN_IF_ERROR(Compare());
    }
    MOTIONDB_RETURN_IF_ERROR(Report(Phase::kPublish, progress_.bytes));
    return target_.Publish();
  }

 private:
  // CANCELLED, or OK.
  absl::Status Report(Phase phase, std::int64_t bytes) {
    progress_.phase = phase;
    progress_.bytes = bytes;
    if (on_progress_) on_progress_(progress_);
    if (cancelled_ && cancelled_()) {
      return absl::CancelledError("cancelled; the same migration continues");
    }
    return absl::OkStatus();
  }

  // Not InTransaction, which may run it twice: the copy cannot go back.
  template <typename Work>
  absl::Status InOneTransaction(const Work& work) {
    Connection& connection = target_.connection();
    MOTIONDB_ASSIGN_OR_RETURN(Transaction transaction,
                              Transaction::Begin(connection, Transaction::Kind::kWrite));
    MOTIONDB_RETURN_IF_ERROR(work(connection));
    return transaction.Commit();
  }

  absl::Status Copy() {
    RowCopy rows(source_.connection(), std::nullopt, RowCopy::Mode::kMove);
    MOTIONDB_RETURN_IF_ERROR(
        InOneTransaction([&](Connection& target) { return rows.Continue(target); }));
    for (bool more = true; more;) {
      MOTIONDB_RETURN_IF_ERROR(Report(Phase::kCopy, rows.copied_bytes()));
      MOTIONDB_RETURN_IF_ERROR(InOneTransaction([&](Connection& target) -> absl::Status {
        MOTIONDB_ASSIGN_OR_RETURN(more, rows.Step(target));
        return absl::OkStatus();
      }));
    }
    MOTIONDB_RETURN_IF_ERROR(Report(Phase::kIndex, rows.copied_bytes()));
    return InOneTransaction([&](Connection& target) -> absl::Status {
      // An interrupted migration may have filled the index.
      MOTIONDB_RETURN_IF_ERROR(target.Query("DELETE FROM clip_text").Run());
      return rows.Finish(target);
    });
  }

  absl::Status Compare() {
    MOTIONDB_ASSIGN_OR_RETURN(const Transaction snapshot,
                              Transaction::Begin(target_.connection(), Transaction::Kind::kRead));
    const absl::Status same = CompareStores(
        source_.connection(), target_.connection(),
        [&](std::int64_t bytes) { Report(Phase::kCompare, bytes).IgnoreError(); }, cancelled_);
    if (!absl::IsDataLoss(same)) return same;
    return core::DataLoss(
        "{} and its copy {} are not equal: {}; either the source was changed after the migration "
        "began, or one of them is corrupt: delete the copy and migrate again",
        source_.name(), target_.name(), std::string(same.message()));
  }

  MigrationEnd& source_;
  MigrationEnd& target_;
  const std::function<void(const MigrationProgress&)>& on_progress_;
  const core::Cancelled& cancelled_;
  MigrationProgress progress_;
};

}  // namespace

absl::Status MigrateStore(const std::string& from, const std::string& to,
                          const std::function<void(const MigrationProgress&)>& on_progress,
                          const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(MigrationEnd source, MigrationEnd::OpenSource(from));
  MOTIONDB_ASSIGN_OR_RETURN(MigrationEnd target, MigrationEnd::OpenTarget(to, source));
  return Migration(source, target, on_progress, cancelled).Run();
}

}  // namespace motiondb::storage
