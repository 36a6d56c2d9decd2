// Import of an exported database into a store of any engine. The file is received and checked; its
// rows are copied under new keys in many short transactions.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "storage/sql/connection/writer.h"
#include "storage/sql/tables/staged_databases.h"
#include "storage/sqlite/received_store.h"
#include "storage/store_maintenance.h"

namespace motiondb::storage {

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
