#include "server/engine/live_database.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/engine/model_lifecycle.h"

namespace motiondb::server {
namespace {

absl::Status Within(const std::string& database, std::string_view what, std::int64_t stored,
                    std::int64_t more, std::int64_t most, std::string_view setting) {
  if (stored + more <= most) return absl::OkStatus();
  return absl::ResourceExhaustedError(fmt::format(
      "database '{}' holds {} {} and may hold {}, so {} more do not fit: delete clips first, or "
      "raise --{}",
      database, stored, what, most, more, setting));
}

}  // namespace

LiveDatabase::LiveDatabase(std::string name, const core::BuildSettings& settings)
    : name_(std::move(name)), settings_(settings) {}

LiveDatabase::~LiveDatabase() = default;

void LiveDatabase::Serve(std::unique_ptr<ModelLifecycle> lifecycle) {
  lifecycle_ = std::move(lifecycle);
}

absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> LiveDatabase::scheme() const {
  const std::lock_guard lock(mutex_);
  return scheme_;
}

void LiveDatabase::set_scheme(absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme) {
  const std::lock_guard lock(mutex_);
  scheme_ = std::move(scheme);
}

std::shared_ptr<const Snapshot> LiveDatabase::snapshot() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

void LiveDatabase::set_snapshot(std::shared_ptr<const Snapshot> snapshot) {
  {
    const std::lock_guard lock(mutex_);
    snapshot_.swap(snapshot);
  }
  // The old model, if no query holds it, is freed here: outside the lock.
}

StoredAmount LiveDatabase::stored() const {
  const std::lock_guard lock(mutex_);
  return stored_;
}

void LiveDatabase::AddStored(const StoredAmount& amount) {
  const std::lock_guard lock(mutex_);
  Add(amount);
}

absl::Status LiveDatabase::Reserve(const StoredAmount& amount, const DatabaseQuota& quota) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_RETURN_IF_ERROR(Within(name_, "clips", stored_.clip_count, amount.clip_count,
                                  quota.clip_count, "max-database-clips"));
  MOTIONDB_RETURN_IF_ERROR(Within(name_, "frames", stored_.frame_count, amount.frame_count,
                                  quota.frame_count, "max-database-frames"));
  MOTIONDB_RETURN_IF_ERROR(Within(name_, "bytes", stored_.byte_count, amount.byte_count,
                                  quota.byte_count, "max-database-mib"));
  Add(amount);
  return absl::OkStatus();
}

void LiveDatabase::Add(const StoredAmount& amount) {
  stored_.clip_count += amount.clip_count;
  stored_.frame_count += amount.frame_count;
  stored_.byte_count += amount.byte_count;
}

RebuildTally LiveDatabase::rebuilds() const {
  const std::lock_guard lock(mutex_);
  return rebuilds_;
}

void LiveDatabase::CountRebuild(std::int64_t RebuildTally::*outcome, double seconds) {
  const std::lock_guard lock(mutex_);
  ++(rebuilds_.*outcome);
  rebuilds_.seconds += seconds;
}

void LiveDatabase::NoteUnreadable(const std::string& clip, const std::string& what) {
  const std::lock_guard lock(mutex_);
  if (!unreadable_.emplace(clip, what).second) return;
  spdlog::error("database '{}': clip '{}' is damaged and left out: {}", name_, clip, what);
}

void LiveDatabase::ForgetUnreadable(const std::string& clip) {
  const std::lock_guard lock(mutex_);
  unreadable_.erase(clip);
}

std::map<std::string, std::string> LiveDatabase::unreadable() const {
  const std::lock_guard lock(mutex_);
  return unreadable_;
}

std::string LiveDatabase::operation() const {
  const std::lock_guard lock(mutex_);
  return operation_;
}

void LiveDatabase::set_operation(std::string operation) {
  const std::lock_guard lock(mutex_);
  operation_ = std::move(operation);
}

absl::Status LiveDatabase::CheckAlive(Retiring retiring, std::unique_lock<std::mutex>& life_lock) {
  if (retiring == Retiring::kAwait) {
    life_changed_.wait(life_lock, [this] { return life_ != Life::kRetiring; });
  }
  switch (life_) {
    case Life::kAlive:
      return absl::OkStatus();
    case Life::kRetiring:
      return absl::UnavailableError(fmt::format("database '{}' is being deleted", name_));
    case Life::kDeleted:
      break;
  }
  return core::NotFound("database '{}' was deleted", name_);
}

absl::Status LiveDatabase::WhileAlive(Retiring retiring,
                                      const std::function<absl::Status()>& change) {
  {
    std::unique_lock lock(life_mutex_);
    MOTIONDB_RETURN_IF_ERROR(CheckAlive(retiring, lock));
    ++changes_;
  }
  const absl::Cleanup ended = [this] {
    const std::lock_guard lock(life_mutex_);
    --changes_;
    life_changed_.notify_all();
  };
  return change();
}

absl::Status LiveDatabase::Retire(const std::function<absl::Status()>& deletion,
                                  const core::Cancelled& cancelled) {
  {
    std::unique_lock lock(life_mutex_);
    MOTIONDB_RETURN_IF_ERROR(CheckAlive(Retiring::kRefuse, lock));
    life_ = Life::kRetiring;
  }
  Life after = Life::kAlive;
  const absl::Cleanup over = [&] {
    const std::lock_guard lock(life_mutex_);
    life_ = after;
    life_changed_.notify_all();
  };
  {
    constexpr std::chrono::milliseconds kBetweenQuestions{20};
    std::unique_lock lock(life_mutex_);
    while (!life_changed_.wait_for(lock, kBetweenQuestions, [this] { return changes_ == 0; })) {
      if (cancelled && cancelled()) {
        return absl::CancelledError("the deletion was no longer wanted when its turn came");
      }
    }
  }
  MOTIONDB_RETURN_IF_ERROR(deletion());
  after = Life::kDeleted;
  return absl::OkStatus();
}

}  // namespace motiondb::server
