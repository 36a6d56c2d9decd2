// Opening the file of a store, and its format: checks and settings of each connection.
// docs/architecture.md explains the settings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// The first bytes of every SQLite file.
inline constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

// Size of the header of an SQLite file.
inline constexpr std::size_t kStoreHeaderBytes = 100;

// Returns the path of the write-ahead log of the store at `store_path`.
inline std::string LogPath(const std::string& store_path) { return store_path + "-wal"; }

// Returns whether `header` begins the file of a store. REQUIRES: at least kStoreHeaderBytes bytes.
bool IsStoreHeader(std::string_view header);

// Returns OK if `path` is missing, an empty file or a store. Otherwise FAILED_PRECONDITION with the
// kind of the file. Changes nothing.
absl::Status CheckIsStore(const std::string& path);

// Returns the version of the store at `path`; 0 if there is no file or no version yet. Call it
// before opening the store, which upgrades it. The codes of CheckIsStore, StoreLock and
// SqliteError.
absl::StatusOr<int> ReadStoreVersion(const std::string& path);

// Opens the only connection that writes and checkpoints; creates and upgrades the store. `path` may
// be ":memory:". REQUIRES: the caller holds the StoreLock.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriter(const std::string& path,
                                                       const std::string& vfs);
// As OpenWriter, for an existing file; UNAVAILABLE if there is none. Errors of an upgrade do not
// name the file.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriterOfExisting(const std::string& path);

// Opens a connection that can only read and never checkpoints.
absl::StatusOr<std::unique_ptr<Connection>> OpenReader(const std::string& path,
                                                       const std::string& vfs);

// Opens a read connection to a store whose file and log do not change. It writes nothing, so the
// file system may be read-only. `is_short`: the file ends before its last page.
absl::StatusOr<std::unique_ptr<Connection>> OpenImmutable(const std::string& path, bool is_short);

// FAILED_PRECONDITION if the store does not have the current version.
absl::Status CheckIsCurrentVersion(Connection& connection);

// Moves the content of the log into the file as far as readers allow, without waiting. If all was
// moved, truncates the log. REQUIRES: `writer` is in no transaction.
void CheckpointLog(Connection& writer);

// Returns the four bytes at offset `place` as a number: SQLite's files have big-endian numbers.
// REQUIRES: place + 4 <= bytes.size().
inline std::uint32_t BigEndian(std::string_view bytes, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t i = place; i < place + 4; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[i]);
  }
  return value;
}

}  // namespace motiondb::storage
