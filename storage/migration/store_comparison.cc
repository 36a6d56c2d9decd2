#include "storage/migration/store_comparison.h"

#include <algorithm>
#include <string>
#include <vector>

#include "core/motion/error.h"
#include "storage/sql/tables/copied_tables.h"

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

}  // namespace

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

}  // namespace motiondb::storage
