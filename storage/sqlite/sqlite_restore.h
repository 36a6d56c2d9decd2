// Restore of a backup into an SQLite store. The backup is written to a file beside the store,
// checked there, and copied into the store by the writer in one transaction.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include "storage/blob/checksums.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/copy_file.h"
#include "storage/sqlite/disk_reserve.h"
#include "storage/sqlite/file_identity.h"
#include "storage/store_maintenance.h"

namespace motiondb::storage {

class SqliteRestore final : public StoreRestore {
 public:
  // `reserve` stays free while the backup is received. `take_over` copies the checked backup into
  // the store.
  using ReplaceContent =
      std::function<absl::Status(Connection& backup, const core::Cancelled& cancelled)>;
  static absl::StatusOr<std::unique_ptr<SqliteRestore>> Make(const std::string& store_path,
                                                             const DiskReserve& reserve,
                                                             ReplaceContent take_over);

  absl::Status Append(std::string_view bytes) override;
  absl::Status Check(const core::Cancelled& cancelled) override;
  absl::Status Finish(const core::Cancelled& cancelled) override;

 private:
  SqliteRestore(const std::string& store_path, const DiskReserve& reserve, ReplaceContent take_over)
      : reserve_(reserve), file_(store_path, "restore"), take_over_(std::move(take_over)) {}
  absl::Status Write(std::string_view bytes);
  absl::Status CheckSum();
  // UNAVAILABLE if the received file was moved, replaced or changed.
  absl::Status CheckIsThere() const;

  const DiskReserve reserve_;
  CopyFile file_;
  std::ofstream stream_;
  FileIdentity opened_;
  std::int64_t written_bytes_ = 0;
  Sha256 digest_;
  std::string tail_;  // the last received bytes, which may be the trailer
  bool begun_ = false;
  std::unique_ptr<Connection> checked_;  // connection to the backup; null before Check
  const ReplaceContent take_over_;
};

// Copies the tokens and audit entries of the target store into the backup that will replace it.
absl::Status CopyAccessRecords(Connection& target, Connection& backup);

}  // namespace motiondb::storage
