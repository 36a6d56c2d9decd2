#include "storage/sqlite/row_checksum.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <map>
#include <span>
#include <string>

#include "core/motion/error.h"
#include "storage/blob/checksums.h"

namespace motiondb::storage {
namespace {

// Returns the UPDATE statement of each table.
std::map<std::string_view, std::string> MakeUpdates() {
  std::map<std::string_view, std::string> updates;
  for (const std::string_view table : CheckedTables()) {
    updates[table] = fmt::format("UPDATE {} SET row_crc = motiondb_crc({}) WHERE {} = ?", table,
                                 ChecksumColumns(table), KeyOfTable(table));
  }
  return updates;
}

template <typename Number>
std::uint32_t CrcOf(Number number, std::uint32_t crc) {
  std::array<std::byte, sizeof(number)> bytes;
  std::memcpy(bytes.data(), &number, sizeof(number));
  return Crc32(bytes, crc);
}

// The SQL function motiondb_crc. The checksum includes types and lengths, so that different lists
// of values have different input.
void Checksum(sqlite3_context* context, int count, sqlite3_value** values) {
  std::uint32_t crc = 0;
  for (sqlite3_value* const value : std::span(values, static_cast<std::size_t>(count))) {
    const int type = sqlite3_value_type(value);
    crc = CrcOf(static_cast<std::uint8_t>(type), crc);
    if (type == SQLITE_INTEGER) {
      crc = CrcOf(static_cast<std::int64_t>(sqlite3_value_int64(value)), crc);
    } else if (type == SQLITE_FLOAT) {
      crc = CrcOf(sqlite3_value_double(value), crc);
    } else if (type != SQLITE_NULL) {
      const auto* const bytes = static_cast<const std::byte*>(sqlite3_value_blob(value));
      const int size = sqlite3_value_bytes(value);
      crc = Crc32(std::span(bytes, static_cast<std::size_t>(size)),
                  CrcOf(static_cast<std::uint32_t>(size), crc));
    }
  }
  sqlite3_result_int64(context, crc);
}

}  // namespace

int AddChecksumFunction(sqlite3* database) {
  return sqlite3_create_function(database, "motiondb_crc", -1,
                                 SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS, nullptr,
                                 Checksum, nullptr, nullptr);
}

absl::Status UpdateRowChecksum(Connection& connection, std::string_view table, std::int64_t key) {
  static const auto kUpdates = MakeUpdates();
  return connection.Query(kUpdates.at(table), key).Run();
}

absl::StatusOr<std::vector<ChangedRow>> FindChangedRows(Connection& connection,
                                                        std::string_view table) {
  return FindRows(connection, table, connection.RowIsChanged(table));
}

}  // namespace motiondb::storage
