// Corrupts the file of a store with SQL or by overwriting bytes.
#pragma once

#include <sqlite3.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>

namespace motiondb::tests {

// Runs a script on the file of a closed store. Returns the first column of the last row as text.
inline std::string RunSql(const std::string& path, const std::string& script) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &database) == SQLITE_OK);
  std::string value;
  const auto keep = [](void* out, int, char** columns, char**) {
    *static_cast<std::string*>(out) = columns[0] == nullptr ? "" : columns[0];
    return 0;
  };
  const int code = sqlite3_exec(database, script.c_str(), keep, &value, nullptr);
  INFO(script << ": " << sqlite3_errmsg(database));
  sqlite3_close(database);
  REQUIRE(code == SQLITE_OK);
  return value;
}

// Returns a script that changes byte `place` of the chunks of `table` that match the condition
// `row`.
inline std::string ChangeByte(const std::string& table, int place, const std::string& row) {
  const std::string at = std::to_string(place);
  return "UPDATE " + table + " SET chunk = CAST(substr(chunk, 1, " + at +
         ") || x'A5' || substr(chunk, " + at + " + 2) AS BLOB) WHERE " + row;
}

// Returns a condition for the rows of clip_chunk of one clip and kind.
inline std::string ChunksOf(const std::string& clip, int kind) {
  return "kind = " + std::to_string(kind) +
         " AND clip_key = (SELECT clip_key FROM clip WHERE id = '" + clip + "')";
}

// Returns a query for the root page of a table or an index.
inline std::string RootPageOf(const std::string& name) {
  return "SELECT rootpage FROM sqlite_schema WHERE name = '" + name + "'";
}

// Replaces each occurrence of `from` in a closed file by `to`, which has the same length.
inline void ReplaceBytes(const std::string& path, const std::string& from, const std::string& to) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::size_t count = 0;
  for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1)) {
    bytes.replace(at, from.size(), to);
    ++count;
  }
  REQUIRE(count > 0);
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

// Overwrites the beginning of a page of a closed store.
inline void CorruptPage(const std::string& path, long page) {
  constexpr long kPageBytes = 16384;
  std::fstream bytes(path, std::ios::in | std::ios::out | std::ios::binary);
  bytes.seekp((page - 1) * kPageBytes);
  bytes << std::string(64, '\x7f');
}

}  // namespace motiondb::tests
