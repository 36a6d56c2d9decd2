// Engine::Open, Restore and ImportDatabase: reads the stored models and resumes unfinished
// operations.
#include <spdlog/spdlog.h>

#include <set>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/compute_model.h"
#include "server/engine/engine.h"
#include "server/engine/snapshot.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {

absl::StatusOr<std::unique_ptr<Engine>> Engine::Open(std::unique_ptr<storage::MotionStore> store,
                                                     const EngineOptions& options) {
  std::unique_ptr<Engine> engine(new Engine(std::move(store), options));
  for (const storage::Corruption& corruption : engine->store_->maintenance().FoundAtOpening()) {
    engine->corruptions_.Note(corruption);
  }
  MOTIONDB_RETURN_IF_ERROR(engine->Load().status());
  if (engine->store_->is_shared()) engine->FollowStore();
  return engine;
}

absl::StatusOr<StoreCounts> Engine::Load() {
  const bool read_only = !store_->maintenance().CheckIsWritable().ok();
  LiveDatabases databases;
  absl::Status status = ReadDatabases(databases);
  if (status.ok() && !read_only) status = ResumeOperations(databases);
  // Serve also if the history of operations is unreadable: the next step finds models that lack
  // clips.
  if (absl::IsDataLoss(status)) {
    corruptions_.Note({"", fmt::format("operations: {}", std::string(status.message()))});
    status = absl::OkStatus();
  }
  if (status.ok() && !read_only) status = RebuildOutdated(databases);
  StoreCounts amount;
  amount.database_count = static_cast<std::int32_t>(databases.size());
  for (const auto& [name, live] : databases) amount.clip_count += live->stored().clip_count;
  // Last: callers then find clips counted and models read. Also done if something could not be read
  // or resumed, because all of it is stored.
  Show(databases);
  if (!status.ok()) return status;
  // The previous server, or the server of the backup, may have stopped before its purge.
  if (!read_only) FreeDeletedDatabases();
  return amount;
}

void Engine::Show(LiveDatabases& databases) {
  const storage::MutexLock lock(mutex_);
  if (draining_) {
    for (const auto& [name, live] : databases) live->lifecycle().BeginStop();
  }
  databases_.merge(databases);
}

absl::Status Engine::ReadDatabases(LiveDatabases& databases) {
  storage::Page page;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto records, store_->ListDatabases(page));
    for (const auto& record : records) {
      // Also if its clips cannot be listed, so that the rest of it can be deleted.
      auto& live = databases[record.name];
      live = Serve(record);
      const absl::Status read = ReadDatabase(*live, record);
      if (absl::IsDataLoss(read)) {
        corruptions_.Note({"databases/" + record.name, std::string(read.message())});
      } else if (!read.ok()) {
        return read;
      }
    }
    if (static_cast<int>(records.size()) < page.limit) return absl::OkStatus();
    page.after = records.back().name;
  }
}

absl::Status Engine::ReadDatabase(LiveDatabase& live, const storage::DatabaseRecord& record) {
  auto scheme = schemes_.Of(record);
  if (!scheme.ok()) {
    corruptions_.Note({"databases/" + record.name, std::string(scheme.status().message())});
  }
  live.set_scheme(std::move(scheme));
  // The previous server may have stopped before its purge.
  if (store_->maintenance().CheckIsWritable().ok()) live.lifecycle().PurgeUnlessBuilding();
  // Queries need only the model, even if the list of clips is corrupt.
  live.lifecycle().LoadStored();
  MOTIONDB_ASSIGN_OR_RETURN(const auto clips, AllClips(*store_, record.name));
  StoredAmount stored;
  for (const auto& clip : clips) {
    stored = stored + AmountOf(clip);
    live.SetDeriveError(clip.id, clip.derive_error);
  }
  live.CountChange(stored, store_->annotations());
  const ServedModel served = live.lifecycle().served();
  spdlog::info("database '{}' opened: clips={} model={}", record.name, clips.size(),
               served.record() == nullptr ? 0 : served.record()->version);
  return absl::OkStatus();
}

absl::Status Engine::ResumeOperations(const LiveDatabases& databases) {
  if (store_->is_shared()) return absl::OkStatus();  // Look finds them
  constexpr int kLimit = 1000;
  std::vector<storage::OperationRecord> unfinished;  // newest first
  std::string before;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto records, store_->ListOperations("", before, kLimit));
    for (const auto& record : records) {
      if (!record.done()) unfinished.push_back(record);
    }
    if (static_cast<int>(records.size()) < kLimit) break;
    before = records.back().id;
  }
  for (auto record = unfinished.rbegin(); record != unfinished.rend(); ++record) {
    const auto live = databases.find(record->database);
    if (live == databases.end()) continue;
    MOTIONDB_ASSIGN_OR_RETURN(const auto operation, operations_.Adopt(*record));
    spdlog::info("database '{}': operation {} resumed", operation.database, operation.id);
    live->second->lifecycle().Resume(operation.id);
  }
  return absl::OkStatus();
}

absl::Status Engine::RebuildOutdated(const LiveDatabases& databases) {
  std::set<std::string> with_operation;
  if (store_->is_shared()) {
    MOTIONDB_ASSIGN_OR_RETURN(const auto unfinished, store_->ListUnfinishedOperations());
    for (const auto& operation : unfinished) with_operation.insert(operation.database);
  }
  for (const auto& [name, live] : databases) {
    if (!live->lifecycle().operation().empty() || with_operation.contains(name)) continue;
    const auto up_to_date = live->lifecycle().IsUpToDate();
    if (absl::IsDataLoss(up_to_date.status())) {
      corruptions_.Note({"databases/" + name, std::string(up_to_date.status().message())});
      continue;
    }
    if (!up_to_date.ok()) return up_to_date.status();
    if (*up_to_date) continue;
    spdlog::info("database '{}': model is out of date with the stored clips; rebuilding", name);
    MOTIONDB_RETURN_IF_ERROR(live->lifecycle().Request().status());
  }
  return absl::OkStatus();
}

absl::StatusOr<StoreCounts> Engine::Restore(storage::StoreRestore& restore,
                                            const core::Cancelled& cancelled) {
  // Takes as long as reading the whole backup. Databases may be created meanwhile; Finish detects
  // that.
  MOTIONDB_RETURN_IF_ERROR(restore.Check(cancelled));
  // No database can be created while this lock is held.
  MOTIONDB_ASSIGN_OR_RETURN(const auto naming, naming_mutex_.Lock(cancelled));
  MOTIONDB_RETURN_IF_ERROR(restore.Finish(cancelled));
  // The backup is stored, and is served even if the caller gave up.
  const core::Cancelled never;
  const storage::ReadScope scope(never);
  skeletons_.Clear();
  MOTIONDB_ASSIGN_OR_RETURN(const StoreCounts amount, Load());
  spdlog::info("backup restored: databases={} clips={}", amount.database_count, amount.clip_count);
  return amount;
}

absl::Status Engine::CheckMayImport(const std::string& database) {
  if (FindDatabase(database).ok()) {
    return core::WithReason("DATABASE_EXISTS", absl::AlreadyExistsError(fmt::format(
                                                   "database '{}' already exists", database)));
  }
  return CheckDatabaseCount();
}

absl::Status Engine::ImportDatabase(std::unique_ptr<storage::DatabaseImport> import,
                                    const storage::ExportedDatabase& content,
                                    const std::string& database,
                                    const storage::WriteOptions& terms) {
  MOTIONDB_RETURN_IF_ERROR(CheckMayImport(database));
  MOTIONDB_RETURN_IF_ERROR(
      LiveDatabase(database, content.record.settings)
          .Reserve({content.clip_count, content.frame_count, content.byte_count}, options_.quota));
  absl::Status imported = import->Stage(terms.cancelled);
  if (imported.ok()) imported = PublishImport(*import, content, database, terms);
  if (!imported.ok()) {
    // After an error the content stays hidden until it is freed, without the import.
    import.reset();
    FreeDeletedDatabases();
  }
  return imported;
}

absl::Status Engine::PublishImport(storage::DatabaseImport& import,
                                   const storage::ExportedDatabase& content,
                                   const std::string& database,
                                   const storage::WriteOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto naming, naming_mutex_.Lock(terms.cancelled));
  MOTIONDB_RETURN_IF_ERROR(CheckMayImport(database));
  MOTIONDB_RETURN_IF_ERROR(import.Publish(database, terms));
  // The database is stored, and is served even if the caller gave up.
  const core::Cancelled never;
  const storage::ReadScope scope(never);
  storage::DatabaseRecord record = content.record;
  record.name = database;
  if (store_->is_shared()) {
    auto stored = store_->GetDatabase(database);
    if (!stored.ok()) return absl::OkStatus();  // it is served when a call needs it
    record = *std::move(stored);
  }
  LiveDatabases databases;
  const auto live = databases[database] = Serve(record);
  absl::Status status = ReadDatabase(*live, record);
  if (status.ok()) status = RebuildOutdated(databases);
  if (!status.ok()) corruptions_.Note({"databases/" + database, std::string(status.message())});
  Show(databases);
  spdlog::info("database '{}': imported: clips={}", database, content.clip_count);
  return absl::OkStatus();
}

}  // namespace motiondb::server
