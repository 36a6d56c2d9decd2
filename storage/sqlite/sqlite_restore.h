// Restore of a backup into a store of any engine. The backup is received and checked in a file, and
// copied into the store by the writer in one transaction.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "storage/sqlite/received_store.h"
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

  absl::Status Append(std::string_view bytes) override { return received_->Append(bytes); }
  absl::Status Check(const core::Cancelled& cancelled) override;
  absl::Status Finish(const core::Cancelled& cancelled) override;

 private:
  SqliteRestore(std::unique_ptr<ReceivedStore> received, ReplaceContent take_over)
      : received_(std::move(received)), take_over_(std::move(take_over)) {}

  const std::unique_ptr<ReceivedStore> received_;
  std::unique_ptr<Connection> checked_;  // connection to the backup; null before Check
  const ReplaceContent take_over_;
};

// Copies the tokens and audit entries of the target store into the backup that will replace it.
absl::Status CopyAccessRecords(Connection& target, Connection& backup);

}  // namespace motiondb::storage
