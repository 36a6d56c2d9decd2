// The store of a simulation: the tables and the code of SqlMotionStore in one SQLite database in
// memory, which all simulated servers share as they would share PostgreSQL, each over a network.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "storage/sql/connection/connection.h"
#include "storage/sql/sql_motion_store.h"
#include "tests/simulation/world.h"

namespace motiondb::simulation {

// A protection of the store that a simulation can remove, to show that it is needed and that its
// absence is found.
enum class Protection { kNone, kFence, kCompareAndSet, kRevision, kDatabase, kRevocation };

// A change of the store by a server.
struct StoreCall {
  std::string_view name;
  std::string database = {};
  std::string object = {};
  std::optional<storage::ModelTerms> terms = {};
  const core::Model* model = nullptr;
  const storage::OperationRecord* operation = nullptr;
};

// The database that the servers share, and its notifications.
class StoreServer {
 public:
  explicit StoreServer(Protection removed);

  storage::Connection& connection() { return *connection_; }
  Protection removed() const { return removed_; }
  // Called after each transaction, with the call of the running task (may be null).
  void OnTransaction(const StoreCall* call);
  // Called after each change by a call, before anything else runs.
  void set_after_change(std::function<void(const StoreCall&)> after_change) {
    after_change_ = std::move(after_change);
  }

  std::unique_ptr<storage::StoreWatch> Watch(Process& process, storage::OnStoreChange on_change);

 private:
  struct Watcher;
  class WatchHandle;
  void Notify();

  const Protection removed_;
  const std::unique_ptr<storage::Connection> connection_;
  std::int64_t seen_changes_ = 0;
  std::function<void(const StoreCall&)> after_change_;
  std::vector<std::shared_ptr<Watcher>> watchers_;
};

class SimulatedStore final : public storage::SqlMotionStore {
 public:
  // The way of a process to the store. Null: a direct one, for checks.
  SimulatedStore(StoreServer& server, Process* process);
  ~SimulatedStore() override { CloseConnections(); }

  bool is_shared() const override { return true; }
  std::unique_ptr<storage::StoreWatch> WatchChanges(storage::OnStoreChange on_change) override {
    return server_.Watch(*process_, std::move(on_change));
  }

  absl::Status CreateDatabase(const storage::DatabaseRecord& record,
                              const storage::WriteOptions& terms = {}) override;
  absl::Status DeleteDatabase(const std::string& database,
                              const storage::WriteOptions& terms = {}) override;
  absl::Status PurgeDeletedDatabases(const core::Cancelled& cancelled) override;
  absl::StatusOr<storage::ClipRecord> AddClip(const storage::NewClip& clip) override;
  absl::StatusOr<storage::ClipRecord> ReplaceClip(const storage::ClipRecord& before,
                                                  const storage::NewClip& clip) override;
  absl::StatusOr<storage::ClipRecord> DeleteClip(const std::string& database,
                                                 const std::string& clip,
                                                 const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<std::vector<storage::ClipRecord>> PutDerived(
      const std::string& database, std::span<const storage::DerivedClip> clips,
      std::int64_t fence = 0) override;
  absl::StatusOr<storage::EditRecord> Edit(const std::string& database,
                                           std::span<const storage::Change> changes,
                                           const std::string& author,
                                           const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<storage::ModelRecord> PutModel(const std::string& database,
                                                const core::Model& model,
                                                const storage::ModelTerms& terms = {}) override;
  absl::StatusOr<storage::ModelRecord> PutExtension(const std::string& database,
                                                    const core::Model& model, double drift_fraction,
                                                    const storage::ModelTerms& terms = {}) override;
  absl::Status DropModel(const std::string& database,
                         const storage::ModelTerms& terms = {}) override;
  absl::StatusOr<std::int64_t> AcquireBuildLease(const std::string& database,
                                                 const std::string& holder,
                                                 std::chrono::milliseconds duration) override;
  absl::Status PutOperation(const storage::OperationRecord& record,
                            const core::Cancelled& cancelled = {}) override;

  absl::Status CheckWrites() override { return absl::OkStatus(); }
  absl::Status CheckIsWritable() const override { return absl::OkStatus(); }
  std::vector<storage::Corruption> FoundAtOpening() const override { return {}; }
  absl::Status CheckFile() override { return absl::OkStatus(); }
  // The following are not simulated.
  absl::StatusOr<std::vector<storage::TextMatch>> SearchClips(const std::string&,
                                                              const std::string&) override;
  absl::StatusOr<std::unique_ptr<storage::StoreVerifier>> BeginVerify(core::Cancelled) override;
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginBackup(
      const core::Cancelled&) override;
  absl::StatusOr<std::unique_ptr<storage::StoreRestore>> BeginRestore() override;
  absl::StatusOr<std::unique_ptr<storage::StoreBackup>> BeginExport(
      const std::string&, const core::Cancelled&) override;
  absl::StatusOr<std::unique_ptr<storage::DatabaseImport>> BeginImport() override;

 private:
  absl::Status CheckMayWrite(storage::Connection&, Added) override { return absl::OkStatus(); }
  bool checks_room() const override { return false; }
  // Returns the terms without the removed protection.
  storage::ModelTerms Weakened(storage::ModelTerms terms) const;

  StoreServer& server_;
  Process* const process_;
};

}  // namespace motiondb::simulation
