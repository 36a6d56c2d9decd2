#include "server/engine/live_database.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "absl/cleanup/cleanup.h"
#include "core/motion/error.h"
#include "server/engine/model_lifecycle.h"

namespace motiondb::server {
namespace {

absl::Status CheckQuota(const std::string& database, std::string_view things, std::int64_t stored,
                        std::int64_t added, std::int64_t limit, std::string_view setting) {
  if (stored + added <= limit) return absl::OkStatus();
  return core::WithReason(
      "QUOTA_EXCEEDED",
      absl::ResourceExhaustedError(fmt::format(
          "database '{}' has {} {}, the limit is {}, so {} more do not fit: delete clips first, or "
          "raise --{}",
          database, stored, things, limit, added, setting)));
}

}  // namespace

LiveDatabase::LiveDatabase(std::string name, const core::BuildSettings& settings)
    : name_(std::move(name)), settings_(settings) {}

LiveDatabase::~LiveDatabase() = default;

void LiveDatabase::SetLifecycle(std::unique_ptr<ModelLifecycle> lifecycle) {
  lifecycle_ = std::move(lifecycle);
}

absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> LiveDatabase::scheme() const {
  const storage::MutexLock lock(mutex_);
  return scheme_;
}

void LiveDatabase::set_scheme(absl::StatusOr<std::shared_ptr<const core::MarkerScheme>> scheme) {
  const storage::MutexLock lock(mutex_);
  scheme_ = std::move(scheme);
}

void LiveDatabase::ReplaceScheme(std::shared_ptr<const core::MarkerScheme> scheme,
                                 std::int64_t time_us) {
  const storage::MutexLock lock(mutex_);
  scheme_ = std::move(scheme);
  scheme_time_us_ = time_us;
}

std::int64_t LiveDatabase::scheme_time_us() const {
  const storage::MutexLock lock(mutex_);
  return scheme_time_us_;
}

StoredAmount LiveDatabase::stored() const {
  const storage::MutexLock lock(mutex_);
  return stored_;
}

void LiveDatabase::CountChange(const StoredAmount& change, storage::AnnotationStore& store) {
  const bool is_shared = id_ != 0;
  if (is_shared && Recount(store).ok()) return;
  const storage::MutexLock lock(mutex_);
  stored_ = stored_ + change;
}

absl::Status LiveDatabase::Recount(storage::AnnotationStore& store) {
  MOTIONDB_ASSIGN_OR_RETURN(const auto catalog, Catalog(store));
  const storage::MutexLock lock(mutex_);
  // Calls may end in another order than their catalogs.
  if (catalog->revision() < counted_revision_) return absl::OkStatus();
  counted_revision_ = catalog->revision();
  stored_ = catalog->stored();
  return absl::OkStatus();
}

absl::Status LiveDatabase::Reserve(const StoredAmount& amount, const DatabaseQuota& quota) {
  const storage::MutexLock lock(mutex_);
  const StoredAmount used = stored_ + reserved_;
  MOTIONDB_RETURN_IF_ERROR(CheckQuota(name_, "clips", used.clip_count, amount.clip_count,
                                      quota.clip_count, "max-database-clips"));
  MOTIONDB_RETURN_IF_ERROR(CheckQuota(name_, "frames", used.frame_count, amount.frame_count,
                                      quota.frame_count, "max-database-frames"));
  MOTIONDB_RETURN_IF_ERROR(CheckQuota(name_, "bytes", used.byte_count, amount.byte_count,
                                      quota.byte_count, "max-database-mib"));
  reserved_ = reserved_ + amount;
  return absl::OkStatus();
}

void LiveDatabase::EndReservation(const StoredAmount& amount) {
  const storage::MutexLock lock(mutex_);
  reserved_ = reserved_ + -amount;
}

void LiveDatabase::AddUnreadable(const std::string& clip, const std::string& what) {
  const storage::MutexLock lock(mutex_);
  if (!unreadable_.emplace(clip, what).second) return;
  spdlog::error("database '{}': clip '{}' is corrupt and left out of models: {}", name_, clip,
                what);
}

void LiveDatabase::ForgetUnreadable(const std::string& clip) {
  const storage::MutexLock lock(mutex_);
  unreadable_.erase(clip);
}

std::map<std::string, std::string> LiveDatabase::unreadable() const {
  const storage::MutexLock lock(mutex_);
  return unreadable_;
}

void LiveDatabase::SetDeriveError(const std::string& clip, const std::string& reason) {
  const storage::MutexLock lock(mutex_);
  if (reason.empty()) {
    underived_.erase(clip);
  } else {
    underived_[clip] = reason;
  }
}

std::map<std::string, std::string> LiveDatabase::underived() const {
  const storage::MutexLock lock(mutex_);
  return underived_;
}

absl::Status LiveDatabase::CheckAlive(DeletionPolicy retiring) {
  if (retiring == DeletionPolicy::kAwait) {
    life_changed_.Wait(mutex_, [this] {
      mutex_.AssertHeld();
      return life_ != Life::kRetiring;
    });
  }
  switch (life_) {
    case Life::kAlive:
      return absl::OkStatus();
    case Life::kRetiring:
      return absl::UnavailableError(fmt::format("database '{}' is being deleted", name_));
    case Life::kDeleted:
      break;
  }
  return core::WithReason("DATABASE_NOT_FOUND", core::NotFound("database '{}' was deleted", name_));
}

absl::Status LiveDatabase::WithSharedUse(DeletionPolicy retiring,
                                         const std::function<absl::Status()>& change) {
  {
    const storage::MutexLock lock(mutex_);
    MOTIONDB_RETURN_IF_ERROR(CheckAlive(retiring));
    ++changes_;
  }
  const absl::Cleanup ended = [this] {
    const storage::MutexLock lock(mutex_);
    --changes_;
    life_changed_.NotifyAll();
  };
  return change();
}

absl::Status LiveDatabase::Retire(const std::function<absl::Status()>& deletion,
                                  const core::Cancelled& cancelled) {
  {
    const storage::MutexLock lock(mutex_);
    MOTIONDB_RETURN_IF_ERROR(CheckAlive(DeletionPolicy::kRefuse));
    life_ = Life::kRetiring;
  }
  Life after = Life::kAlive;
  const absl::Cleanup over = [&] {
    const storage::MutexLock lock(mutex_);
    life_ = after;
    life_changed_.NotifyAll();
  };
  {
    const storage::MutexLock lock(mutex_);
    const auto unchanged = [this] {
      mutex_.AssertHeld();
      return changes_ == 0;
    };
    if (!life_changed_.WaitOrCancel(mutex_, cancelled, unchanged)) {
      return absl::CancelledError("the deletion was cancelled while it waited for running changes");
    }
  }
  MOTIONDB_RETURN_IF_ERROR(deletion());
  after = Life::kDeleted;
  return absl::OkStatus();
}

}  // namespace motiondb::server
