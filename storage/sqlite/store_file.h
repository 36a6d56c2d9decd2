// Opening the file of a store: what may be opened, and how each connection is set up. Functions
// keep no state. docs/architecture.md explains the settings.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// What every SQLite file begins with.
inline constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

// As many bytes tell what a SQLite file is.
inline constexpr std::size_t kStoreHeaderBytes = 100;

// Of SQLite's write-ahead log of the store at `store_path`.
inline std::string LogPath(const std::string& store_path) { return store_path + "-wal"; }

// Whether a file that begins so is a store's. REQUIRES: at least kStoreHeaderBytes.
bool IsStoreHeader(std::string_view header);

// OK if there is nothing at `path`, an empty file or a store. Else FAILED_PRECONDITION saying what
// it is, leaving it as it was.
absl::Status CheckIsStore(const std::string& path);

// The version of the store at `path`, to be asked before it is opened, which upgrades it; 0 where
// there is nothing, or no version yet. The codes of CheckIsStore, StoreLock and SQLite.
absl::StatusOr<int> ReadStoreVersion(const std::string& path);

// The one connection that writes and checkpoints; makes and upgrades the store. `path` may be
// ":memory:". Its holder holds the StoreLock.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriter(const std::string& path,
                                                       const std::string& vfs);
// The same of a file that there is; UNAVAILABLE where there is none. Errors of an upgrade do not
// name the file.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriterOfExisting(const std::string& path);

// A connection that can only read, and never checkpoints.
absl::StatusOr<std::unique_ptr<Connection>> OpenReader(const std::string& path,
                                                       const std::string& vfs);

// A connection that reads a store that nobody changes meanwhile, its log included. It writes
// nothing, so that it may be on a file system that is read-only. `is_short`: the file ends before
// its last page.
absl::StatusOr<std::unique_ptr<Connection>> OpenUnchanging(const std::string& path, bool is_short);

// FAILED_PRECONDITION unless the store is of the version that migrations lead to.
absl::Status CheckIsOfThisVersion(Connection& connection);

// Moves what the log holds into the file, as far as no reader is in the way, and if all of it,
// gives the log's room back; waits for nobody. REQUIRES: `writer` is in no transaction.
void EmptyLog(Connection& writer);

}  // namespace motiondb::storage
