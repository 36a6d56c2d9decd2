#include "tests/simulation/simulated_store.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/model/model.h"
#include "storage/cancellable_lock.h"
#include "storage/sqlite/sqlite_connection.h"
#include "storage/sqlite/store_file.h"

namespace motiondb::simulation {
namespace {

using storage::Writer;

// Removes the write of revisions: a change gets the next one, but the database keeps the last.
constexpr char kKeepRevision[] = R"sql(
CREATE TEMP TRIGGER keep_revision AFTER UPDATE OF revision ON database
BEGIN
  UPDATE database SET revision = OLD.revision WHERE database_key = NEW.database_key;
END;
)sql";

// The row of a freed database stays: SQLite would use its key again, which PostgreSQL does not.
constexpr char kKeepKey[] = R"sql(
CREATE TEMP TRIGGER keep_key BEFORE DELETE ON database
BEGIN
  SELECT RAISE(IGNORE);
END;
)sql";

constexpr seconds kMaxCallDelay{8};     // longer than a build lease
constexpr seconds kMaxConnectDelay{3};  // until a lost connection is noticed

absl::Status Unreachable() { return absl::UnavailableError("the store cannot be reached"); }

// The way of a server to the store.
class NetworkSession final : public Writer::Session {
 public:
  NetworkSession(StoreServer& server, Process& process) : server_(server), process_(process) {}

  storage::Connection& connection() override { return server_.connection(); }

  absl::Status Begin(const core::Cancelled& cancelled) override {
    if (absl::Status arrived = Travel(); !arrived.ok()) return arrived;
    World& world = World::Current();
    if (world.Chance(world.hazards.slow_call)) world.Sleep(world.Between({}, kMaxCallDelay));
    if (process_.is_dead || world.Chance(world.hazards.refused_call)) return Unreachable();
    return cancelled && cancelled() ? storage::CancelledInQueue() : absl::OkStatus();
  }

  void OnEnd() override { server_.OnTransaction(World::Current().task()->call); }

  absl::Status Answer() override {
    if (absl::Status arrived = Travel(); !arrived.ok()) return arrived;
    World& world = World::Current();
    const StoreCall* const call = world.task()->call;
    const bool extends = call != nullptr && call->name == "PutExtension";
    const Hazards& hazards = world.hazards;
    const bool is_lost = world.Chance(
        extends ? std::max(hazards.lost_answer, hazards.lost_extension) : hazards.lost_answer);
    return is_lost ? Unreachable() : absl::OkStatus();
  }

 private:
  absl::Status Travel() {
    World& world = World::Current();
    if (!process_.is_dead) world.Sleep(world.Between(microseconds(50), milliseconds(1)));
    if (process_.is_dead) return Unreachable();
    if (process_.cut_off_until <= world.now()) return absl::OkStatus();
    world.Sleep(world.Between({}, kMaxConnectDelay));
    return Unreachable();
  }

  StoreServer& server_;
  Process& process_;
};

class DirectSession final : public Writer::Session {
 public:
  explicit DirectSession(StoreServer& server) : server_(server) {}
  storage::Connection& connection() override { return server_.connection(); }
  absl::Status Begin(const core::Cancelled&) override { return absl::OkStatus(); }
  void OnEnd() override {}
  absl::Status Answer() override { return absl::OkStatus(); }

 private:
  StoreServer& server_;
};

std::unique_ptr<Writer::Session> NewSession(StoreServer& server, Process* process) {
  if (process == nullptr) return std::make_unique<DirectSession>(server);
  return std::make_unique<NetworkSession>(server, *process);
}

// The call of the running task as long as it lives.
class CallScope {
 public:
  explicit CallScope(StoreCall call) : call_(std::move(call)) {
    World::Current().task()->call = &call_;
  }
  ~CallScope() { World::Current().task()->call = nullptr; }
  CallScope(const CallScope&) = delete;
  CallScope& operator=(const CallScope&) = delete;

 private:
  const StoreCall call_;
};

absl::Status NotSimulated() { return absl::UnimplementedError("not simulated"); }

// A new database in memory, copied from one that has the tables: making them takes longer.
std::unique_ptr<storage::Connection> NewDatabase() {
  static const std::unique_ptr<storage::Connection> made = *storage::OpenWriter(":memory:", "");
  auto copy = *storage::SqliteConnection::Open(":memory:", SQLITE_OPEN_READWRITE, "");
  sqlite3_backup* const backup =
      sqlite3_backup_init(storage::HandleOf(*copy), "main", storage::HandleOf(*made), "main");
  sqlite3_backup_step(backup, -1);
  sqlite3_backup_finish(backup);
  copy->Execute("PRAGMA foreign_keys = ON; PRAGMA trusted_schema = OFF;").IgnoreError();
  return copy;
}

}  // namespace

struct StoreServer::Watcher {
  Process* process = nullptr;
  storage::OnStoreChange on_change;
  bool is_open = true;
  int running = 0;
  WaitList all_ended;
};

class StoreServer::WatchHandle final : public storage::StoreWatch {
 public:
  WatchHandle(StoreServer& server, std::shared_ptr<Watcher> watcher)
      : server_(server), watcher_(std::move(watcher)) {}
  ~WatchHandle() override {
    watcher_->is_open = false;
    std::erase(server_.watchers_, watcher_);
    while (watcher_->running > 0) watcher_->all_ended.Wait();
  }

 private:
  StoreServer& server_;
  const std::shared_ptr<Watcher> watcher_;
};

StoreServer::StoreServer(Protection removed) : removed_(removed), connection_(NewDatabase()) {
  connection_->Execute(kKeepKey).IgnoreError();
  if (removed == Protection::kRevision) connection_->Execute(kKeepRevision).IgnoreError();
}

void StoreServer::OnTransaction(const StoreCall* call) {
  const std::int64_t changes = sqlite3_total_changes64(storage::HandleOf(*connection_));
  if (std::exchange(seen_changes_, changes) == changes) return;
  if (call != nullptr) {
    World::Current().Trace(fmt::format("{} {} {}", call->name, call->database, call->object));
    if (after_change_) after_change_(*call);
  }
  Notify();
}

void StoreServer::Notify() {
  World& world = World::Current();
  for (const auto& watcher : watchers_) {
    const bool is_lost = watcher->process->is_dead ||
                         watcher->process->cut_off_until > world.now() ||
                         world.Chance(world.hazards.lost_notice);
    if (is_lost) continue;
    world.Start(
        watcher->process,
        [watcher] {
          if (!watcher->is_open) return;
          ++watcher->running;
          watcher->on_change({});
          if (--watcher->running == 0) watcher->all_ended.WakeAll();
        },
        world.Between(microseconds(100), milliseconds(20)));
  }
}

std::unique_ptr<storage::StoreWatch> StoreServer::Watch(Process& process,
                                                        storage::OnStoreChange on_change) {
  auto watcher = std::make_shared<Watcher>(Watcher{&process, std::move(on_change)});
  watchers_.push_back(watcher);
  return std::make_unique<WatchHandle>(*this, std::move(watcher));
}

SimulatedStore::SimulatedStore(StoreServer& server, Process* process)
    : SqlMotionStore(std::make_unique<Writer>(NewSession(server, process)), nullptr,
                     [] { return World::Current().WallMicroseconds(); }),
      server_(server),
      process_(process) {}

absl::Status SimulatedStore::CreateDatabase(const storage::DatabaseRecord& record,
                                            const storage::WriteOptions& terms) {
  const CallScope scope({"CreateDatabase", record.name});
  return SqlMotionStore::CreateDatabase(record, terms);
}

absl::Status SimulatedStore::DeleteDatabase(const std::string& database,
                                            const storage::WriteOptions& terms) {
  const CallScope scope({"DeleteDatabase", database});
  return SqlMotionStore::DeleteDatabase(database, terms);
}

absl::Status SimulatedStore::PurgeDeletedDatabases(const core::Cancelled& cancelled) {
  const CallScope scope({"PurgeDeletedDatabases"});
  return SqlMotionStore::PurgeDeletedDatabases(cancelled);
}

absl::StatusOr<storage::ClipRecord> SimulatedStore::AddClip(const storage::NewClip& clip) {
  const CallScope scope({"AddClip", clip.record.database, clip.record.id});
  if (server_.removed() != Protection::kDatabase) return SqlMotionStore::AddClip(clip);
  storage::NewClip of_any = clip;
  of_any.database_id = 0;
  return SqlMotionStore::AddClip(of_any);
}

absl::StatusOr<storage::ClipRecord> SimulatedStore::ReplaceClip(const storage::ClipRecord& before,
                                                                const storage::NewClip& clip) {
  const CallScope scope({"ReplaceClip", clip.record.database, before.id});
  return SqlMotionStore::ReplaceClip(before, clip);
}

absl::StatusOr<storage::ClipRecord> SimulatedStore::DeleteClip(const std::string& database,
                                                               const std::string& clip,
                                                               const storage::WriteOptions& terms) {
  const CallScope scope({"DeleteClip", database, clip});
  return SqlMotionStore::DeleteClip(database, clip, terms);
}

absl::StatusOr<std::vector<storage::ClipRecord>> SimulatedStore::PutDerived(
    const std::string& database, std::span<const storage::DerivedClip> clips, std::int64_t fence) {
  const CallScope scope({"PutDerived", database});
  return SqlMotionStore::PutDerived(database, clips, fence);
}

absl::StatusOr<storage::EditRecord> SimulatedStore::Edit(const std::string& database,
                                                         std::span<const storage::Change> changes,
                                                         const std::string& author,
                                                         const storage::WriteOptions& terms) {
  const CallScope scope({"Edit", database});
  return SqlMotionStore::Edit(database, changes, author, terms);
}

absl::StatusOr<storage::ModelRecord> SimulatedStore::PutModel(const std::string& database,
                                                              const core::Model& model,
                                                              const storage::ModelTerms& terms) {
  const CallScope scope({"PutModel", database, {}, terms, &model});
  return SqlMotionStore::PutModel(database, model, Weakened(terms));
}

absl::StatusOr<storage::ModelRecord> SimulatedStore::PutExtension(
    const std::string& database, const core::Model& model, double drift_fraction,
    const storage::ModelTerms& terms) {
  const CallScope scope({"PutExtension", database, {}, terms, &model});
  return SqlMotionStore::PutExtension(database, model, drift_fraction, Weakened(terms));
}

absl::Status SimulatedStore::DropModel(const std::string& database,
                                       const storage::ModelTerms& terms) {
  const CallScope scope({"DropModel", database, {}, terms});
  return SqlMotionStore::DropModel(database, Weakened(terms));
}

absl::StatusOr<std::int64_t> SimulatedStore::AcquireBuildLease(const std::string& database,
                                                               const std::string& holder,
                                                               std::chrono::milliseconds duration) {
  const CallScope scope({"AcquireBuildLease", database});
  return SqlMotionStore::AcquireBuildLease(database, holder, duration);
}

absl::Status SimulatedStore::PutOperation(const storage::OperationRecord& record,
                                          const core::Cancelled& cancelled) {
  // The second part of an id is random.
  const std::string first = record.id.substr(0, record.id.find('-'));
  const CallScope scope({.name = "PutOperation",
                         .database = record.database,
                         .object = fmt::format("{} {}", first, static_cast<int>(record.state)),
                         .operation = &record});
  return SqlMotionStore::PutOperation(record, cancelled);
}

storage::ModelTerms SimulatedStore::Weakened(storage::ModelTerms terms) const {
  if (server_.removed() == Protection::kFence) {
    terms.fence |= std::numeric_limits<std::uint32_t>::max();  // the last one of the database
  }
  if (server_.removed() == Protection::kCompareAndSet) terms.base_version.reset();
  return terms;
}

absl::StatusOr<std::vector<storage::TextMatch>> SimulatedStore::SearchClips(const std::string&,
                                                                            const std::string&) {
  return NotSimulated();
}

absl::StatusOr<std::unique_ptr<storage::StoreVerifier>> SimulatedStore::BeginVerify(
    core::Cancelled) {
  return NotSimulated();
}

absl::StatusOr<std::unique_ptr<storage::StoreBackup>> SimulatedStore::BeginBackup(
    const core::Cancelled&) {
  return NotSimulated();
}

absl::StatusOr<std::unique_ptr<storage::StoreRestore>> SimulatedStore::BeginRestore() {
  return NotSimulated();
}

absl::StatusOr<std::unique_ptr<storage::StoreBackup>> SimulatedStore::BeginExport(
    const std::string&, const core::Cancelled&) {
  return NotSimulated();
}

absl::StatusOr<std::unique_ptr<storage::DatabaseImport>> SimulatedStore::BeginImport() {
  return NotSimulated();
}

}  // namespace motiondb::simulation
