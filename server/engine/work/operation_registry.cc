#include "server/engine/work/operation_registry.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <random>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/work/clock.h"
#include "storage/thread_scopes.h"

namespace motiondb::server {
namespace {

using storage::OperationRecord;
using storage::OperationState;

// Ids ascend with time. The random part separates servers, and ids after a clock was set back.
std::string NewOperationId(std::int64_t now_us) {
  thread_local std::mt19937 random{std::random_device{}()};
  return fmt::format("{:014x}-{:08x}", now_us, random());
}

void MakePending(OperationRecord& record) {
  record.state = OperationState::kPending;
  record.progress = 0;
  record.stage = "waiting";
}

void LogUnstored(const std::string& id, const absl::Status& error) {
  spdlog::error("operation {} could not be stored and is kept in memory only: {}", id,
                error.ToString());
}

}  // namespace

absl::StatusOr<OperationRecord> OperationRegistry::Create(const std::string& database,
                                                          const core::Cancelled& cancelled,
                                                          storage::OperationKind kind,
                                                          std::int64_t database_id) {
  OperationRecord record;
  record.kind = kind;
  record.create_time_us = NowMicroseconds();
  record.id = NewOperationId(record.create_time_us);
  record.database = database;
  record.database_id = database_id;
  return Add(std::move(record), cancelled);
}

absl::StatusOr<OperationRecord> OperationRegistry::Adopt(OperationRecord record) {
  return Add(std::move(record), {});
}

absl::StatusOr<OperationRecord> OperationRegistry::Add(OperationRecord record,
                                                       const core::Cancelled& cancelled) {
  MakePending(record);
  record.update_time_us = NowMicroseconds();
  const absl::Status stored = store_.PutOperation(record, cancelled);
  if (absl::IsNotFound(stored) || absl::IsCancelled(stored)) return stored;
  if (!stored.ok() && is_shared_) return stored;
  if (!stored.ok()) LogUnstored(record.id, stored);
  const storage::MutexLock lock(mutex_);
  Live& live = live_[record.id];
  live.record = record;
  live.stored = stored.ok();
  return record;
}

absl::StatusOr<OperationRecord> OperationRegistry::Get(const std::string& id) {
  std::optional<OperationRecord> known;
  {
    const storage::MutexLock lock(mutex_);
    const auto live = live_.find(id);
    if (live != live_.end() && IsNewest(live->second)) return live->second.record;
    if (live != live_.end()) known = live->second.record;
  }
  auto stored = store_.GetOperation(id);
  if (known && absl::IsUnavailable(stored.status())) return *std::move(known);
  return stored;
}

absl::StatusOr<std::vector<OperationRecord>> OperationRegistry::List(const std::string& database,
                                                                     const std::string& before,
                                                                     int limit) {
  MOTIONDB_ASSIGN_OR_RETURN(auto records, store_.ListOperations(database, before, limit));
  const storage::MutexLock lock(mutex_);
  for (OperationRecord& record : records) {
    const auto live = live_.find(record.id);
    if (live != live_.end() && IsNewest(live->second)) record = live->second.record;
  }
  return records;
}

bool OperationRegistry::Start(const std::string& id) {
  Change(id, Durability::kStored, [](OperationRecord& record) {
    record.state = OperationState::kRunning;
    record.stage = "starting";
  }).IgnoreError();
  const storage::MutexLock lock(mutex_);
  const auto live = live_.find(id);
  if (live == live_.end()) return !is_shared_;
  live->second.is_here = true;
  return true;
}

void OperationRegistry::HandOver(const std::string& id) {
  const storage::MutexLock lock(mutex_);
  if (const auto live = live_.find(id); live != live_.end()) live->second.is_here = false;
}

void OperationRegistry::Advance(const std::string& id, double progress, std::string_view stage) {
  Change(id, Durability::kInMemory, [&](OperationRecord& record) {
    record.progress = progress;
    record.stage = stage;
  }).IgnoreError();
}

void OperationRegistry::Postpone(const std::string& id) {
  Change(id, Durability::kStored, MakePending).IgnoreError();
  HandOver(id);
}

absl::Status OperationRegistry::Succeed(const std::string& id, int model_version,
                                        const std::string& remark) {
  return Change(id, Durability::kStored, [&](OperationRecord& record) {
    record.state = OperationState::kSucceeded;
    record.progress = 1;
    record.stage = remark.empty() ? "done" : "done, " + remark;
    record.model_version = model_version;
  });
}

absl::Status OperationRegistry::Fail(const std::string& id, const absl::Status& error) {
  return Change(id, Durability::kStored, [&](OperationRecord& record) {
    record.state = OperationState::kFailed;
    record.error_code = static_cast<std::int32_t>(error.code());
    record.error_message = std::string(error.message());
  });
}

absl::Status OperationRegistry::Cancel(const std::string& id, const core::Cancelled& cancelled) {
  const auto end = [](OperationRecord& record) { record.state = OperationState::kCancelled; };
  return Change(id, Durability::kStored, end, cancelled);
}

absl::StatusOr<bool> OperationRegistry::CancelAnywhere(const std::string& id,
                                                       const core::Cancelled& cancelled) {
  MOTIONDB_ASSIGN_OR_RETURN(const OperationRecord record, store_.GetOperation(id));
  if (record.done()) return false;
  Observe(record);
  MOTIONDB_RETURN_IF_ERROR(Cancel(id, cancelled));
  MOTIONDB_ASSIGN_OR_RETURN(const OperationRecord after, Get(id));
  return after.state == OperationState::kCancelled;
}

void OperationRegistry::Observe(const OperationRecord& stored) {
  std::map<std::uint64_t, Watcher> watchers;
  {
    const storage::MutexLock lock(mutex_);
    const auto live = live_.try_emplace(stored.id).first;
    if (live->second.is_here || !live->second.stored) return;
    live->second.record = stored;
    if (!stored.done()) return;
    watchers = std::exchange(live->second.watchers, {});
    live_.erase(live);
  }
  for (const auto& [key, watcher] : watchers) watcher(stored);
}

void OperationRegistry::Follow(const std::vector<OperationRecord>& unfinished) {
  std::map<std::string, OperationRecord> ended;  // perhaps: those that are not in the list
  {
    const storage::MutexLock lock(mutex_);
    for (const auto& [id, live] : live_) {
      if (!live.is_here && live.stored) ended.emplace(id, live.record);
    }
  }
  for (const OperationRecord& record : unfinished) {
    ended.erase(record.id);
    Observe(record);
  }
  for (auto& [id, record] : ended) {
    const auto stored = store_.GetOperation(id);
    if (stored.ok()) {
      Observe(*stored);
    } else if (absl::IsNotFound(stored.status())) {  // deleted with its database
      record.state = OperationState::kCancelled;
      Observe(record);
    }
  }
}

void OperationRegistry::Abandon(const std::string& id) {
  // A new database may have the name, and the operation: Follow looks into the store.
  if (is_shared_) return HandOver(id);
  Change(id, Durability::kInMemory, [](OperationRecord& record) {
    record.state = OperationState::kCancelled;
  }).IgnoreError();
}

// Stored before it is visible: a state that a client has seen survives a restart, if it could be
// stored. Changes of one operation are sequential, so no change is lost between the two locks.
absl::Status OperationRegistry::Change(const std::string& id, Durability durability,
                                       const std::function<void(OperationRecord&)>& change,
                                       const core::Cancelled& cancelled) {
  OperationRecord record;
  bool is_stored = false;
  {
    const storage::MutexLock lock(mutex_);
    const auto live = live_.find(id);
    if (live == live_.end() || live->second.record.done()) return absl::OkStatus();
    record = live->second.record;
    is_stored = live->second.stored;
  }
  change(record);
  record.update_time_us = NowMicroseconds();
  absl::Status stored;
  if (durability == Durability::kStored) {
    stored = store_.PutOperation(record, cancelled);
    if (absl::IsCancelled(stored)) return stored;
    // Another server has ended it, or the answer to an earlier try was lost.
    if (absl::IsAborted(stored)) {
      const auto ended = store_.GetOperation(id);
      if (ended.ok()) record = *ended;
      stored = ended.status();
    }
    // Deleted with its database.
    if (absl::IsNotFound(stored)) {
      record.state = OperationState::kCancelled;
      stored = absl::OkStatus();
    }
    if (!stored.ok() && is_shared_) return stored;
    if (is_stored && !stored.ok()) LogUnstored(id, stored);
    is_stored = stored.ok();
  }
  std::map<std::uint64_t, Watcher> watchers;
  {
    const storage::MutexLock lock(mutex_);
    const auto live = live_.find(id);
    if (live == live_.end()) return absl::OkStatus();
    live->second.record = record;
    live->second.stored = is_stored;
    if (record.done()) {
      watchers = std::exchange(live->second.watchers, {});
      // If it could not be stored, only this entry has the result.
      if (stored.ok()) live_.erase(live);
    }
  }
  for (const auto& [key, watcher] : watchers) watcher(record);
  return absl::OkStatus();
}

std::uint64_t OperationRegistry::Watch(const std::string& id, Watcher watcher) {
  if (is_shared_) {
    // Follow has not seen the newest operations of other servers.
    const auto stored = store_.GetOperation(id);
    if (stored.ok()) Observe(*stored);
  }
  const storage::MutexLock lock(mutex_);
  const auto live = live_.find(id);
  if (live == live_.end() || live->second.record.done() || released_) return 0;
  // A watcher resumes another call, which must not fail with the caller's work.
  live->second.watchers.emplace(next_key_,
                                [watcher = std::move(watcher)](const OperationRecord& record) {
                                  const storage::AllocationsMayFail::Pause pause;
                                  watcher(record);
                                });
  return next_key_++;
}

void OperationRegistry::Unwatch(const std::string& id, std::uint64_t key) {
  const storage::MutexLock lock(mutex_);
  if (const auto live = live_.find(id); live != live_.end()) live->second.watchers.erase(key);
}

void OperationRegistry::EndWaits() {
  std::vector<std::pair<Watcher, OperationRecord>> released;
  {
    const storage::MutexLock lock(mutex_);
    released_ = true;
    for (auto& [id, live] : live_) {
      for (auto& [key, watcher] : live.watchers) {
        released.emplace_back(std::move(watcher), live.record);
      }
      live.watchers.clear();
    }
  }
  for (const auto& [watcher, record] : released) watcher(record);
}

}  // namespace motiondb::server
