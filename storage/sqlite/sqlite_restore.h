// A backup on its way into a SQLite store: gathered in a file beside the store, checked there, and
// copied into the store by the one connection that writes, in one transaction.
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
#include "storage/store_upkeep.h"

namespace motiondb::storage {

class SqliteRestore final : public StoreRestore {
 public:
  // What comes in leaves `reserve` free. `take_over` copies from a connection to the backup's
  // store, which has passed all checks.
  using TakeOver =
      std::function<absl::Status(Connection& backup, const core::Cancelled& cancelled)>;
  static absl::StatusOr<std::unique_ptr<SqliteRestore>> Make(const std::string& store_path,
                                                             const DiskReserve& reserve,
                                                             TakeOver take_over);

  absl::Status Append(std::string_view bytes) override;
  absl::Status Check(const core::Cancelled& cancelled) override;
  absl::Status Finish(const core::Cancelled& cancelled) override;

 private:
  SqliteRestore(const std::string& store_path, const DiskReserve& reserve, TakeOver take_over)
      : reserve_(reserve), file_(store_path, "restore"), take_over_(std::move(take_over)) {}
  absl::Status Write(std::string_view bytes);
  absl::Status CheckSum();
  // Whether the file that was written is where it was: UNAVAILABLE.
  absl::Status CheckIsThere() const;

  const DiskReserve reserve_;
  CopyFile file_;
  std::ofstream stream_;
  FileIdentity opened_;
  std::int64_t written_bytes_ = 0;
  Sha256 digest_;
  std::string tail_;  // the last bytes so far, which may be the trailer
  bool begun_ = false;
  std::unique_ptr<Connection> checked_;  // to the backup's store; null before Check
  const TakeOver take_over_;
};

// Brings what a target has of tokens and records of changes to a backup that will take its place.
absl::Status KeepAccess(Connection& target, Connection& backup);

}  // namespace motiondb::storage
