// Backup of a store, or of one of its databases: the file of an SQLite store. First all pages, or
// rows, are copied to a temporary file: otherwise the read transaction would last as long as the
// slowest client, and the log could not be emptied.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "storage/blob/checksums.h"
#include "storage/sql/connection/connection.h"
#include "storage/sqlite/store_disk.h"
#include "storage/store_maintenance.h"

namespace motiondb::storage {

class SqliteBackup final : public StoreBackup {
 public:
  // `reader`: a read connection to the store at `store_path`, in a transaction; not used after the
  // call.
  static absl::StatusOr<std::unique_ptr<SqliteBackup>> Make(Connection& reader,
                                                            const std::string& store_path,
                                                            const core::Cancelled& cancelled);
  // The same, of one database. The copy leaves `reserve` free. `reader` may be of any engine.
  static absl::StatusOr<std::unique_ptr<SqliteBackup>> MakeExport(Connection& reader,
                                                                  const std::string& database,
                                                                  const std::string& store_path,
                                                                  const DiskReserve& reserve,
                                                                  const core::Cancelled& cancelled);
  // The same, of a whole store of any engine, whose rows are copied.
  static absl::StatusOr<std::unique_ptr<SqliteBackup>> MakeOfRows(Connection& reader,
                                                                  const std::string& store_path,
                                                                  const core::Cancelled& cancelled);

  std::int64_t total_bytes() const override;
  absl::StatusOr<bool> Read(std::string& block) override;

 private:
  SqliteBackup(const std::string& store_path, const std::string& purpose)
      : file_(store_path, purpose) {}
  absl::Status CopyRows(Connection& reader, std::optional<std::int64_t> database_key,
                        const DiskReserve& reserve, const core::Cancelled& cancelled);
  // Opens the complete copy.
  absl::Status OpenCopy();

  CopyFile file_;
  std::ifstream stream_;
  std::int64_t file_bytes_ = 0;
  std::int64_t read_bytes_ = 0;
  Sha256 digest_;
  bool ended_ = false;
};

inline constexpr std::string_view kBackupMark = "mtdbback";
inline constexpr std::size_t kBackupTrailerBytes = kBackupMark.size() + kSha256Bytes;
inline constexpr std::size_t kBackupBlockBytes = 1 << 20;

// Copies all pages from a consistent view of `from` to `to`; after an error `to` is unchanged.
// REQUIRES: `from` is in a transaction that has read, or has no other writer; `to` is in no
// transaction. CANCELLED, or the codes of SqliteError.
absl::Status CopyPages(Connection& from, Connection& to, const core::Cancelled& cancelled);

}  // namespace motiondb::storage
