// How an Engine follows the changes that other servers make in a shared store.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/motion/error.h"
#include "server/engine/engine.h"
#include "server/engine/work/clock.h"

namespace motiondb::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLookPeriod{1000};
// At least this long between two calls of the followers, if notifications cause many looks. With
// kLookPeriod, a call comes after 1.5 s at the latest: a revoked token is refused within 2 s.
constexpr milliseconds kMinFollowPeriod{500};
// From a notification to the look: a burst of them causes one.
constexpr milliseconds kWakeDelay{50};
// Frees the space of databases that were deleted by a server that died, or during an outage.
constexpr std::chrono::minutes kPurgePeriod{10};
// Longest wait for running changes of a database that another server has deleted.
constexpr milliseconds kMaxDropWait{500};

}  // namespace

void Engine::FollowStore() {
  last_look_ = workers_.Now();
  {
    const storage::MutexLock lock(look_mutex_);
    next_look_ = workers_.MakeTimer(Pool::kChanges);
    next_purge_ = workers_.Now() + kPurgePeriod;
    next_look_->Set(workers_.Now(), [this] { Look(); });
  }
  {
    const storage::MutexLock lock(wake_mutex_);
    wake_ = workers_.MakeTimer(Pool::kChanges);
  }
  watch_ = store_->WatchChanges([this](const storage::StoreChange&) { LookNow(); });
}

void Engine::LookNow() {
  const storage::MutexLock lock(wake_mutex_);
  if (wake_ == nullptr || is_waking_) return;
  is_waking_ = true;
  wake_->Set(workers_.Now() + kWakeDelay, [this] {
    {
      const storage::MutexLock woken(wake_mutex_);
      is_waking_ = false;
    }
    Look();
  });
}

void Engine::StopFollowing() {
  watch_ = nullptr;
  {
    const storage::MutexLock lock(wake_mutex_);
    wake_ = nullptr;
  }
  const storage::MutexLock lock(look_mutex_);
  next_look_ = nullptr;
  followers_.clear();
}

double Engine::SecondsSinceLook() {
  const Executor::Clock::time_point last = last_look_;
  if (last == Executor::Clock::time_point()) return 0;
  return std::chrono::duration<double>(workers_.Now() - last).count();
}

void Engine::AddFollower(std::function<void()> follower) {
  const storage::MutexLock lock(look_mutex_);
  followers_.push_back(std::move(follower));
}

void Engine::Look() {
  const storage::MutexLock lock(look_mutex_);
  if (next_look_ == nullptr) return;  // draining
  const auto began = workers_.Now();
  // First: a look can wait for changes of deleted databases.
  if (began >= next_follow_) {
    next_follow_ = began + kMinFollowPeriod;
    for (const auto& follower : followers_) follower();
  }
  const absl::Status looked = LookAtStore();
  if (looked.ok()) last_look_ = began;
  if (looked.ok() != std::exchange(sees_store_, looked.ok())) {
    if (looked.ok()) {
      spdlog::info("the store answers again: changes of other servers are followed");
      next_purge_ = began;
    } else {
      spdlog::error("changes of other servers cannot be followed: {}",
                    std::string(looked.message()));
    }
  }
  const auto now = workers_.Now();
  if (looked.ok() && now >= next_purge_ && store_->maintenance().CheckIsWritable().ok()) {
    next_purge_ = now + kPurgePeriod;
    FreeDeletedDatabases();
  }
  next_look_->Set(workers_.Now() + kLookPeriod, [this] { Look(); });
}

absl::Status Engine::LookAtStore() {
  MOTIONDB_ASSIGN_OR_RETURN(const auto unfinished, store_->ListUnfinishedOperations());
  operations_.Follow(unfinished);
  std::set<std::string> changed;
  const absl::Status followed = FollowDatabases(changed);
  std::map<std::int64_t, std::vector<std::string>> ids;  // by database
  for (const auto& operation : unfinished) ids[operation.database_id].push_back(operation.id);
  for (const auto& live : Databases()) {
    live->lifecycle().Follow(ids[live->id()], changed.contains(live->name()));
  }
  return followed;
}

absl::Status Engine::FollowDatabases(std::set<std::string>& changed) {
  // If a database is created or deleted here now, the next look is soon enough.
  const auto naming = naming_mutex_.Lock([] { return true; });
  if (!naming.ok()) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, store_->ListDatabaseStates());
  std::map<std::string, std::int64_t> stored;
  for (const auto& state : states) stored[state.name] = state.id;
  for (const auto& live : Databases()) {
    const auto found = stored.find(live->name());
    if (found == stored.end() || found->second != live->id()) DropDatabase(live);
  }
  std::erase_if(seen_, [this](const auto& seen) {
    const auto live = FindServed(seen.first);
    return live == nullptr || live->id() != seen.second.state.id;
  });
  for (const auto& state : states) {
    const auto live = FindServed(state.name);
    if (live != nullptr && live->id() != state.id) continue;  // could not be dropped yet
    const auto seen = seen_.find(state.name);
    if (seen != seen_.end() && seen->second.state.stamp == state.stamp) continue;
    MOTIONDB_RETURN_IF_ERROR(FollowDatabase(state));
    changed.insert(state.name);
  }
  // A replaced or deleted clip may have had the last use of a skeleton.
  if (!changed.empty()) skeletons_.Clear();
  return absl::OkStatus();
}

absl::Status Engine::LookFor(const std::string& database) {
  MOTIONDB_RETURN_IF_ERROR(store_->GetDatabase(database).status());
  const storage::MutexLock lock(look_mutex_);
  const auto naming = naming_mutex_.Lock([] { return true; });
  if (!naming.ok() || next_look_ == nullptr) {
    return absl::UnavailableError(
        fmt::format("database '{}' is not served here yet: try again", database));
  }
  if (FindServed(database) != nullptr) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const auto states, store_->ListDatabaseStates());
  const auto state = std::ranges::find(states, database, &storage::DatabaseState::name);
  if (state == states.end()) return absl::OkStatus();  // deleted meanwhile
  MOTIONDB_RETURN_IF_ERROR(FollowDatabase(*state));
  if (const auto live = FindServed(database)) live->lifecycle().Follow({}, /*is_changed=*/true);
  return absl::OkStatus();
}

absl::Status Engine::FollowDatabase(const storage::DatabaseState& state) {
  auto record = store_->GetDatabase(state.name);
  if (absl::IsNotFound(record.status())) return absl::OkStatus();  // the next look finds out
  if (!record.ok()) return record.status();
  const auto seen = seen_.find(state.name);
  auto live = FindServed(state.name);
  // The last look may have seen neither, or only the new one.
  if (live != nullptr && live->id() != record->id) {
    if (!DropDatabase(live)) return absl::OkStatus();
    live = nullptr;
  }
  if (live == nullptr) {
    LiveDatabases databases;
    live = databases[state.name] = Serve(*record);
    live->set_scheme(schemes_.Of(*record));
    Show(databases);
    spdlog::info("database '{}': served; another server has created it", state.name);
  } else if (seen == seen_.end() || record->marker_set_text != seen->second.marker_set_text) {
    auto scheme = schemes_.Of(*record);
    if (seen != seen_.end() && scheme.ok()) {
      live->ReplaceScheme(*std::move(scheme), NowMicroseconds());
    } else {
      live->set_scheme(std::move(scheme));
    }
  }
  // If it was created again after the states were read, the next look follows it again.
  const bool is_of_state = record->id == state.id;
  seen_[state.name] = {is_of_state ? state : storage::DatabaseState{state.name, record->id},
                       std::move(record->marker_set_text)};
  live->set_seen_revision(is_of_state ? state.revision : 0);
  live->signal()->Notify();
  return absl::OkStatus();
}

bool Engine::DropDatabase(const std::shared_ptr<LiveDatabase>& live) {
  const auto latest = workers_.Now() + kMaxDropWait;
  const auto forget = [&] {
    live->lifecycle().Forget();
    const storage::MutexLock lock(mutex_);
    databases_.erase(live->name());
    return absl::OkStatus();
  };
  if (!live->Retire(forget, [&] { return workers_.Now() > latest; }).ok()) return false;
  live->signal()->Notify();
  spdlog::info("database '{}': no longer served; another server has deleted it", live->name());
  return true;
}

absl::Status Engine::ReadScheme(LiveDatabase& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto known, database.scheme());
  if (known != nullptr) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const auto record, store_->GetDatabase(database.name()));
  if (!record.marker_set_text.empty()) database.set_scheme(schemes_.Of(record));
  return absl::OkStatus();
}

}  // namespace motiondb::server
