#include "server/engine/engine.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/format/marker_set_file.h"
#include "core/motion/error.h"
#include "server/engine/build_lease.h"
#include "server/engine/operator_log.h"
#include "server/engine/work/clock.h"

namespace motiondb::server {

namespace {

absl::Status NoDatabase(const std::string& database) {
  return core::WithReason("DATABASE_NOT_FOUND",
                          core::NotFound("database '{}' does not exist", database));
}

// Another server may delete a database, and create it again under its name, during a call.
storage::WriteOptions WithDatabase(storage::WriteOptions terms, const LiveDatabase& database) {
  terms.database_id = database.id();
  return terms;
}

EngineOptions WithWork(EngineOptions options, storage::MotionStore& store) {
  // A server of a file is the only one that can build. One that may not write builds nothing.
  if (!store.is_shared()) options.work = ServerWork::kBoth;
  if (store.is_shared() && !store.maintenance().CheckIsWritable().ok()) {
    options.work = ServerWork::kServe;
  }
  if (options.work == ServerWork::kBuild && options.model_memory_bytes == 0) {
    options.model_memory_bytes = 1;  // one model always stays
  }
  return options;
}

}  // namespace

Engine::Engine(std::unique_ptr<storage::MotionStore> store, const EngineOptions& options)
    : options_(WithWork(options, *store)),
      name_(NewHolderName()),
      store_(std::move(store)),
      operations_(*store_),
      skeletons_(*store_),
      workers_(options) {}

Engine::~Engine() {
  Drain();
  // The last handlers use members that are destroyed before the pools.
  workers_.Join();
}

void Engine::Drain() {
  draining_ = true;
  StopFollowing();
  operations_.EndWaits();
  const auto databases = Databases();
  for (const auto& database : databases) database->lifecycle().BeginStop();
  for (const auto& database : databases) database->lifecycle().AwaitStop();
}

std::shared_ptr<LiveDatabase> Engine::Serve(const storage::DatabaseRecord& record) {
  auto live = std::make_shared<LiveDatabase>(record.name, record.settings);
  if (store_->is_shared()) live->set_id(record.id);
  LifecycleServices services{*store_, operations_, corruptions_, workers_, options_, name_};
  if (options_.model_memory_bytes > 0) {
    services.make_room = [this](std::int64_t bytes) { MakeRoom(bytes); };
  }
  live->SetLifecycle(std::make_unique<ModelLifecycle>(*live, services));
  return live;
}

absl::StatusOr<storage::DatabaseRecord> Engine::CreateDatabase(const std::string& database,
                                                               const core::BuildSettings& settings,
                                                               const MarkerSetSetting& marker_set,
                                                               const storage::WriteOptions& terms) {
  if (const absl::Status valid = core::CheckSettings(settings); !valid.ok()) {
    return core::Within("database", valid);
  }
  const storage::DatabaseRecord record{.name = database,
                                       .settings = settings,
                                       .marker_set = marker_set.name,
                                       .marker_set_text = marker_set.text,
                                       .create_time_us = NowMicroseconds()};
  MOTIONDB_ASSIGN_OR_RETURN(auto scheme, schemes_.Of(record));
  auto live = Serve(record);
  live->set_scheme(std::move(scheme));
  MOTIONDB_ASSIGN_OR_RETURN(const auto naming, naming_mutex_.Lock(terms.cancelled));
  MOTIONDB_RETURN_IF_ERROR(CheckDatabaseCount());
  MOTIONDB_RETURN_IF_ERROR(store_->CreateDatabase(record, terms));
  spdlog::info("database '{}': created", database);
  if (store_->is_shared()) {
    const auto stored = store_->GetDatabase(database);
    // It is served when a call needs it. Another server may have deleted it and created it again.
    if (!stored.ok() || stored->create_time_us != record.create_time_us) return record;
    live->set_id(stored->id);
  }
  const storage::MutexLock lock(mutex_);
  if (draining_) live->lifecycle().BeginStop();
  databases_[database] = std::move(live);
  return record;
}

absl::Status Engine::DeleteDatabase(const std::string& database,
                                    const storage::WriteOptions& terms) {
  // Before the mutex is held: a database that only other servers know is served first.
  MOTIONDB_RETURN_IF_ERROR(FindDatabase(database).status());
  MOTIONDB_ASSIGN_OR_RETURN(const auto naming, naming_mutex_.Lock(terms.cancelled));
  const auto live = FindServed(database);
  if (live == nullptr) return NoDatabase(database);
  const auto remove = [&] {
    const absl::Status deleted = store_->DeleteDatabase(database, WithDatabase(terms, *live));
    if (!deleted.ok()) return deleted;
    live->lifecycle().Forget();
    const storage::MutexLock lock(mutex_);
    databases_.erase(database);
    return absl::OkStatus();
  };
  MOTIONDB_RETURN_IF_ERROR(live->Retire(remove, terms.cancelled));
  live->signal()->Notify();
  skeletons_.Clear();
  spdlog::info("database '{}': deleted", database);
  FreeDeletedDatabases();
  return absl::OkStatus();
}

absl::Status Engine::ChangeMarkerScheme(const std::string& database, const SchemeChange& change,
                                        const storage::WriteOptions& terms) {
  MOTIONDB_RETURN_IF_ERROR(store_->maintenance().CheckIsWritable());
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, FindDatabase(database));
  // Without a scheme, the ingest of the first clip can hold the mutex for minutes.
  MOTIONDB_ASSIGN_OR_RETURN(const auto current, live->scheme());
  if (current == nullptr) return NoMarkerSet(database);
  MOTIONDB_ASSIGN_OR_RETURN(const auto changing, live->scheme_mutex().Lock(terms.cancelled));
  return live->WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(auto record, store_->GetDatabase(database));
    MOTIONDB_ASSIGN_OR_RETURN(const auto before, schemes_.Of(record));
    if (before == nullptr) return NoMarkerSet(database);
    MOTIONDB_ASSIGN_OR_RETURN(const core::MarkerScheme changed, change(*before));
    const std::string before_text =
        std::exchange(record.marker_set_text, core::WriteMarkerSetFile(changed));
    const std::size_t bytes = record.marker_set_text.size();
    if (bytes > kMaxMarkerSetBytes && bytes > before_text.size()) {
      return core::WithReason(
          "QUOTA_EXCEEDED",
          absl::ResourceExhaustedError(
              fmt::format("the marker set of database '{}' would have {} bytes; the maximum is {}",
                          database, bytes, kMaxMarkerSetBytes)));
    }
    MOTIONDB_ASSIGN_OR_RETURN(auto scheme, schemes_.Of(record));
    MOTIONDB_RETURN_IF_ERROR(store_->ReplaceMarkerSet(database, before_text, record.marker_set_text,
                                                      WithDatabase(terms, *live)));
    live->ReplaceScheme(std::move(scheme), NowMicroseconds());
    spdlog::info("database '{}': marker set changed: mappings={}", database,
                 changed.mappings.size());
    return absl::OkStatus();
  });
}

void Engine::FreeDeletedDatabases() {
  if (draining_ || purge_queued_.exchange(true)) return;
  workers_.Post(Pool::kMaintenance, [this] {
    purge_queued_ = false;  // reset first: this run may miss a database deleted later
    const absl::Status freed = store_->PurgeDeletedDatabases(
        [this] { return draining_.load() || workers_.queued(Pool::kMaintenance) > 0; });
    if (absl::IsCancelled(freed)) return FreeDeletedDatabases();  // after the queued work
    if (freed.ok()) return;
    spdlog::warn("purge of deleted databases failed: {}", freed.ToString());
  });
}

absl::Status Engine::CheckDatabaseCount() {
  const storage::MutexLock lock(mutex_);
  if (databases_.size() < options_.max_databases) return absl::OkStatus();
  return core::WithReason(
      "QUOTA_EXCEEDED",
      absl::ResourceExhaustedError(fmt::format(
          "there are already {} databases, the maximum: delete one first, or raise --max-databases",
          databases_.size())));
}

absl::StatusOr<std::shared_ptr<LiveDatabase>> Engine::FindDatabase(const std::string& database) {
  auto live = FindServed(database);
  if (live == nullptr && store_->is_shared()) {
    MOTIONDB_RETURN_IF_ERROR(LookFor(database));
    live = FindServed(database);
  }
  if (live == nullptr) return NoDatabase(database);
  return live;
}

std::shared_ptr<LiveDatabase> Engine::FindServed(const std::string& database) {
  const storage::MutexLock lock(mutex_);
  const auto found = databases_.find(database);
  return found == databases_.end() ? nullptr : found->second;
}

std::vector<std::shared_ptr<LiveDatabase>> Engine::Databases() {
  const storage::MutexLock lock(mutex_);
  std::vector<std::shared_ptr<LiveDatabase>> databases;
  databases.reserve(databases_.size());
  for (const auto& [name, database] : databases_) databases.push_back(database);
  return databases;
}

std::optional<storage::OperationRecord> Engine::CurrentOperation(const LiveDatabase& database) {
  const std::string id = database.lifecycle().operation();
  if (id.empty()) return std::nullopt;
  auto operation = operations_.Get(id);
  if (!operation.ok() || operation->done()) return std::nullopt;  // it has ended meanwhile
  return *std::move(operation);
}

absl::StatusOr<std::unique_ptr<ModelLifecycle::Ingest>> Engine::BeginIngest(
    const std::shared_ptr<LiveDatabase>& database) {
  MOTIONDB_RETURN_IF_ERROR(store_->maintenance().CheckIsWritable());
  std::unique_ptr<ModelLifecycle::Ingest> ingest;
  MOTIONDB_RETURN_IF_ERROR(database->WithSharedUse(DeletionPolicy::kRefuse, [&] {
    ingest = std::make_unique<ModelLifecycle::Ingest>(database);
    return absl::OkStatus();
  }));
  return ingest;
}

absl::StatusOr<Ingested> Engine::Ingest(const std::shared_ptr<LiveDatabase>& database,
                                        IngestRequest request, const WorkOptions& terms) {
  Ingested ingested;
  const bool replaces = request.replace && !request.validate_only;
  const auto stored = [&](const storage::ClipRecord& record) -> absl::Status {
    spdlog::info("database '{}': clip '{}' stored: frames={}; {}", record.database, record.id,
                 record.frame_count, record.source_report);
    database->signal()->Notify();
    database->lifecycle().RequestUpdate();
    MOTIONDB_ASSIGN_OR_RETURN(ingested.operation, database->lifecycle().Request(terms.cancelled));
    return absl::OkStatus();
  };
  if (store_->is_shared()) MOTIONDB_RETURN_IF_ERROR(ReadScheme(*database));
  MOTIONDB_ASSIGN_OR_RETURN(ingested.clip,
                            IngestClip(*store_, *database, std::move(request), options_,
                                       workers_.Parallel(Pool::kRequests), terms, stored));
  if (replaces) skeletons_.Clear();
  return ingested;
}

absl::StatusOr<storage::OperationRecord> Engine::DeleteClip(const std::string& database,
                                                            const std::string& clip,
                                                            const storage::WriteOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, FindDatabase(database));
  storage::OperationRecord operation;
  const absl::Status deleted = live->WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(const storage::ClipRecord record,
                              store_->DeleteClip(database, clip, WithDatabase(terms, *live)));
    live->signal()->Notify();
    live->ForgetUnreadable(clip);
    live->SetDeriveError(clip, "");
    skeletons_.Clear();
    live->CountChange(-AmountOf(record), store_->annotations());
    spdlog::info("database '{}': clip '{}' deleted", database, clip);
    live->lifecycle().PurgeUnlessBuilding(terms.cancelled);
    MOTIONDB_ASSIGN_OR_RETURN(operation, live->lifecycle().Request(terms.cancelled));
    return absl::OkStatus();
  });
  MOTIONDB_RETURN_IF_ERROR(deleted);
  return operation;
}

namespace {

// Returns whether the edit changed a label, its range, or a subject: models depend on these.
bool ConcernsModel(const storage::EditRecord& edit) {
  const auto changed = [](const storage::EditedObject& object) {
    if (!object.before || !object.after) return true;
    if (const auto* before = std::get_if<storage::ClipRecord>(&*object.before)) {
      const auto& after = std::get<storage::ClipRecord>(*object.after);
      return before->label != after.label || before->subject != after.subject;
    }
    const auto& before = std::get<storage::SegmentRecord>(*object.before);
    const auto& after = std::get<storage::SegmentRecord>(*object.after);
    return before.label != after.label || before.start_seconds != after.start_seconds ||
           before.end_seconds != after.end_seconds;
  };
  return std::ranges::any_of(edit.objects, changed);
}

}  // namespace

absl::StatusOr<Edited> Engine::Edit(const std::string& database,
                                    std::span<const storage::Change> changes,
                                    const std::string& author, const storage::WriteOptions& terms,
                                    EditFields fields) {
  std::vector<storage::Change> checked(changes.begin(), changes.end());
  MOTIONDB_RETURN_IF_ERROR(CheckChanges(checked, fields));
  const auto edit = [&](const storage::WriteOptions& with_database) {
    return store_->annotations().Edit(database, checked, author, with_database);
  };
  return StoreEdit(database, edit, terms);
}

absl::StatusOr<Edited> Engine::UndoEdit(const std::string& database, std::int64_t edit,
                                        const std::string& author,
                                        const storage::WriteOptions& terms) {
  const auto undo = [&](const storage::WriteOptions& with_database) {
    return store_->annotations().UndoEdit(database, edit, author, with_database);
  };
  return StoreEdit(database, undo, terms);
}

absl::StatusOr<Edited> Engine::StoreEdit(const std::string& database, const EditStore& edit,
                                         const storage::WriteOptions& terms) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, FindDatabase(database));
  Edited edited;
  const absl::Status stored = live->WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(edited.edit, edit(WithDatabase(terms, *live)));
    if (edited.edit.id == 0) {
      MOTIONDB_ASSIGN_OR_RETURN(edited.revision, store_->annotations().Revision(database));
      return absl::OkStatus();
    }
    edited.revision = edited.edit.id;
    live->signal()->Notify();
    live->lifecycle().RequestUpdate();
    if (!ConcernsModel(edited.edit)) return absl::OkStatus();
    MOTIONDB_ASSIGN_OR_RETURN(edited.operation, live->lifecycle().Request(terms.cancelled));
    return absl::OkStatus();
  });
  MOTIONDB_RETURN_IF_ERROR(stored);
  return edited;
}

absl::StatusOr<storage::OperationRecord> Engine::ReprocessDatabase(
    const std::string& database, const core::Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(store_->maintenance().CheckIsWritable());
  MOTIONDB_ASSIGN_OR_RETURN(const auto live, FindDatabase(database));
  storage::OperationRecord operation;
  MOTIONDB_RETURN_IF_ERROR(live->WithSharedUse(DeletionPolicy::kRefuse, [&]() -> absl::Status {
    MOTIONDB_ASSIGN_OR_RETURN(operation, live->lifecycle().RequestReprocess(cancelled));
    return absl::OkStatus();
  }));
  return operation;
}

void Engine::RecordLater(const storage::AuditRecord& record) {
  workers_.Post(Pool::kMaintenance,
                [this, record] { StoreAuditRecord(store_->access(), record).IgnoreError(); });
}

std::vector<storage::Corruption> Engine::corruptions() {
  std::vector<storage::Corruption> corruptions;
  {
    const storage::MutexLock lock(mutex_);
    for (const auto& [name, live] : databases_) {
      for (const auto& [clip, what] : live->unreadable()) {
        corruptions.push_back({fmt::format("databases/{}/clips/{}", name, clip), what});
      }
    }
  }
  for (storage::Corruption& corruption : corruptions_.List()) {
    const bool known = std::ranges::any_of(corruptions, [&](const storage::Corruption& other) {
      return other.resource == corruption.resource && other.description == corruption.description;
    });
    if (!known) corruptions.push_back(std::move(corruption));
  }
  if (corruptions.size() > CorruptionLog::kLimit) corruptions.resize(CorruptionLog::kLimit);
  return corruptions;
}

absl::StatusOr<Cancellation> Engine::CancelOperation(const std::string& operation,
                                                     const core::Cancelled& cancelled) {
  MOTIONDB_RETURN_IF_ERROR(store_->maintenance().CheckIsWritable());
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, operations_.Get(operation));
  bool is_first = false;
  const auto database = FindDatabase(record.database);
  if (!record.done() && database.ok()) {
    const auto cancel = [&]() -> absl::Status {
      MOTIONDB_ASSIGN_OR_RETURN(is_first, (*database)->lifecycle().Cancel(operation, cancelled));
      return absl::OkStatus();
    };
    const absl::Status done = (*database)->WithSharedUse(DeletionPolicy::kRefuse, cancel);
    // An operation of a deleted database ends by itself.
    if (!done.ok() && !absl::IsNotFound(done)) return done;
  }
  if (!is_first && !record.done() && store_->is_shared()) {
    MOTIONDB_ASSIGN_OR_RETURN(is_first, operations_.CancelAnywhere(operation, cancelled));
  }
  MOTIONDB_ASSIGN_OR_RETURN(auto after, operations_.Get(operation));
  return Cancellation{std::move(after), is_first};
}

}  // namespace motiondb::server
