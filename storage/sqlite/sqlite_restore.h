// Restore of a backup, and import of an exported database, into a store of any engine. The file is
// received and checked (received_store.h).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "storage/sql/connection/writer.h"
#include "storage/sql/tables/deleted_databases.h"
#include "storage/sqlite/received_store.h"
#include "storage/store_maintenance.h"

namespace motiondb::storage {

// The writer copies the backup into the store in one transaction.
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

// The rows of the file are copied under new keys in many short transactions.
class SqliteImport final : public DatabaseImport {
 public:
  // Runs `piece`, which adds about `added_bytes`, in a transaction of the store.
  using Piece = std::function<absl::Status(Connection&)>;
  using Transact = std::function<absl::Status(Priority priority, const WriteOptions& terms,
                                              std::int64_t added_bytes, const Piece& piece)>;
  // `reserve` stays free while the file is received. `staged` must outlive the object.
  static absl::StatusOr<std::unique_ptr<SqliteImport>> Make(const std::string& store_path,
                                                            const DiskReserve& reserve,
                                                            StagedDatabases& staged,
                                                            Transact transact);
  ~SqliteImport() override { Unstage(); }

  absl::Status Append(std::string_view bytes) override { return received_->Append(bytes); }
  absl::StatusOr<ExportedDatabase> Check(const core::Cancelled& cancelled) override;
  absl::Status Stage(const core::Cancelled& cancelled) override;
  absl::Status Publish(const std::string& database, const WriteOptions& terms) override;

 private:
  SqliteImport(std::unique_ptr<ReceivedStore> received, StagedDatabases& staged, Transact transact)
      : received_(std::move(received)), staged_(staged), transact_(std::move(transact)) {}
  void Unstage();

  const std::unique_ptr<ReceivedStore> received_;
  StagedDatabases& staged_;
  const Transact transact_;
  std::unique_ptr<Connection> checked_;  // connection to the file; null before Check, after Stage
  std::int64_t source_key_ = 0;          // of the database in the file
  std::int64_t staged_key_ = 0;          // of the database in the store; 0: not staged
  bool is_complete_ = false;             // all of it is staged
};

}  // namespace motiondb::storage
