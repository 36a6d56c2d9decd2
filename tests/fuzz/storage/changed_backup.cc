#include "tests/fuzz/storage/changed_backup.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "storage/blob/checksums.h"
#include "storage/sqlite/sqlite_backup.h"
#include "tests/fuzz/server/trained_engine.h"
#include "tests/fuzz/support/properties.h"
#include "tests/support/temporary_directory.h"

namespace motiondb::tests {
namespace {

// Reads an input from its front; returns zeros after its end.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), remaining_(size) {}
  bool empty() const { return remaining_ == 0; }
  template <typename Number>
  Number Take() {
    Number number = 0;
    const std::string bytes = Bytes(sizeof(number));
    std::memcpy(&number, bytes.data(), bytes.size());
    return number;
  }
  std::string Bytes(std::size_t count) {
    count = std::min(count, remaining_);
    std::string bytes(reinterpret_cast<const char*>(data_), count);
    data_ += count;
    remaining_ -= count;
    return bytes;
  }

 private:
  const std::uint8_t* data_;
  std::size_t remaining_;
};

struct Column {
  std::string table;
  std::string name;
};

// A backup without its checksum, the positions of its nonzero bytes, and its tables.
struct Base {
  std::string bytes;
  std::vector<std::uint32_t> not_zero;
  std::vector<std::vector<Column>> tables;
};

std::string BackupOfTrained() {
  const auto backup = Trained().engine->store().maintenance().BeginBackup({});
  CheckContract(backup.ok(), "a backup begins");
  std::string bytes;
  std::string block;
  while (true) {
    const auto more = (*backup)->Read(block);
    CheckContract(more.ok(), "a backup is read");
    if (!*more) break;
    bytes += block;
  }
  bytes.resize(bytes.size() - storage::kBackupTrailerBytes);
  return bytes;
}

// An open SQLite file with these bytes. The destructor reads the changed file back into `bytes`.
class OpenFile {
 public:
  explicit OpenFile(std::string& bytes) : bytes_(bytes), path_(directory_ / "changed.db") {
    std::ofstream(path_, std::ios::binary) << bytes;
    CheckContract(sqlite3_open(path_.c_str(), &handle_) == SQLITE_OK, "a backup can be opened");
    Run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA foreign_keys = OFF; "
        "PRAGMA ignore_check_constraints = ON");
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    sqlite3_close(handle_);
    std::ifstream stream(path_, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
  }
  // Returns false if SQLite refuses the script.
  bool Run(const std::string& script) {
    return sqlite3_exec(handle_, script.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
  }
  sqlite3* handle() { return handle_; }

 private:
  const TemporaryDirectory directory_;
  std::string& bytes_;
  const std::string path_;
  sqlite3* handle_ = nullptr;
};

std::vector<std::vector<Column>> TablesOf(OpenFile& file) {
  std::vector<std::vector<Column>> tables;
  sqlite3_stmt* statement = nullptr;
  sqlite3_prepare_v2(file.handle(),
                     "SELECT t.name, c.name FROM sqlite_schema t, pragma_table_info(t.name) c "
                     "WHERE t.type = 'table' ORDER BY t.name, c.cid",
                     -1, &statement, nullptr);
  while (sqlite3_step(statement) == SQLITE_ROW) {
    const auto text = [&](int column) {
      return std::string(reinterpret_cast<const char*>(sqlite3_column_text(statement, column)));
    };
    Column column{text(0), text(1)};
    if (tables.empty() || tables.back().front().table != column.table) tables.emplace_back();
    tables.back().push_back(std::move(column));
  }
  sqlite3_finalize(statement);
  return tables;
}

const Base& TheBase() {
  static const Base kBase = [] {
    Base base;
    base.bytes = BackupOfTrained();
    for (std::size_t i = 0; i < base.bytes.size(); ++i) {
      if (base.bytes[i] != 0) base.not_zero.push_back(static_cast<std::uint32_t>(i));
    }
    OpenFile file(base.bytes);
    base.tables = TablesOf(file);
    return base;
  }();
  return kBase;
}

std::string ValueFrom(Input& input) {
  const auto kind = input.Take<std::uint8_t>() % 5;
  if (kind == 0) return fmt::format("{}", input.Take<std::int64_t>());
  if (kind == 1) return fmt::format("{}", input.Take<std::int8_t>());
  if (kind == 2) return "NULL";
  std::string digits;
  for (const char byte : input.Bytes(input.Take<std::uint8_t>())) {
    digits += fmt::format("{:02x}", static_cast<std::uint8_t>(byte));
  }
  return kind == 3 ? fmt::format("x'{}'", digits) : fmt::format("CAST(x'{}' AS TEXT)", digits);
}

void SetValue(Input& input, std::string& bytes) {
  const Base& base = TheBase();
  const auto& table = base.tables[input.Take<std::uint8_t>() % base.tables.size()];
  const Column& column = table[input.Take<std::uint8_t>() % table.size()];
  const auto row = input.Take<std::uint8_t>();
  OpenFile file(bytes);
  const std::string set =
      fmt::format("UPDATE {} SET {} = {}", column.table, column.name, ValueFrom(input));
  const bool has_rows = file.Run(fmt::format(
      "{0} WHERE rowid = (SELECT rowid FROM {1} LIMIT 1 OFFSET {2} % (SELECT count(*) FROM {1}))",
      set, column.table, row));
  if (!has_rows) file.Run(set);  // all rows of a table without rowid
}

void WriteBytes(Input& input, std::string& bytes, bool only_where_not_zero) {
  const Base& base = TheBase();
  std::size_t place = input.Take<std::uint32_t>();
  place = only_where_not_zero ? base.not_zero[place % base.not_zero.size()] : place;
  const std::string written = input.Bytes(input.Take<std::uint8_t>());
  if (bytes.empty()) return;
  place %= bytes.size();
  const std::size_t count = std::min(written.size(), bytes.size() - place);
  bytes.replace(place, count, written, 0, count);
}

}  // namespace

std::string ChangedBackup(const std::uint8_t* data, std::size_t size) {
  std::string bytes = TheBase().bytes;
  Input input(data, size);
  const bool sealed = (input.Take<std::uint8_t>() & 1) != 0;
  while (!input.empty()) {
    const auto kind = input.Take<std::uint8_t>() % 3;
    if (kind == 2) {
      SetValue(input, bytes);
    } else {
      WriteBytes(input, bytes, kind == 1);
    }
  }
  bytes += storage::kBackupMark;
  storage::Sha256 digest;
  digest.Update(sealed ? bytes : TheBase().bytes);
  return bytes + digest.Finish();
}

}  // namespace motiondb::tests
