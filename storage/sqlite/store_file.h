// Opening the file of a store: what may be opened, and how each connection is set up. Functions
// keep no state. storage/README.md explains the settings.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// What every SQLite file begins with.
inline constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

// OK if there is nothing at `path`, an empty file or a store. Else FAILED_PRECONDITION saying what
// it is, leaving it as it was.
absl::Status CheckIsStore(const std::string& path);

// The one connection that writes and checkpoints; makes and upgrades the store. `path` may be
// ":memory:". Its holder holds the StoreLock.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriter(const std::string& path,
                                                       const std::string& vfs);
// The same of a file that there is; UNAVAILABLE where there is none.
absl::StatusOr<std::unique_ptr<Connection>> OpenWriterOfExisting(const std::string& path);

// A connection that can only read, and never checkpoints.
absl::StatusOr<std::unique_ptr<Connection>> OpenReader(const std::string& path,
                                                       const std::string& vfs);

}  // namespace motiondb::storage
