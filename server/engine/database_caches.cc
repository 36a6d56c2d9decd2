#include "server/engine/database_caches.h"

#include <algorithm>

#include "core/motion/error.h"

namespace motiondb::server {
namespace {

using storage::MutexLock;

constexpr int kChangesAtOnce = 1000;
constexpr std::size_t kMaxMasks = 16;

}  // namespace

absl::StatusOr<DatabaseCatalog::Pointer> DatabaseCatalog::Current(storage::AnnotationStore& store,
                                                                  const std::string& database) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t revision, store.Revision(database));
  const MutexLock lock(mutex_);
  std::int64_t begun = catalog_->revision() == 0 ? revision : 0;
  while (catalog_->revision() < revision) {
    const auto changes = store.Changes(database, catalog_->revision(), kChangesAtOnce, begun);
    if (absl::IsOutOfRange(changes.status()) && catalog_->revision() > 0) {
      catalog_ = std::make_shared<const Catalog>();
      begun = revision;
      continue;
    }
    if (!changes.ok()) return changes.status();
    if (changes->empty()) break;  // the last revision only changed what a later one changed again
    catalog_ = std::make_shared<const Catalog>(catalog_->With(*changes));
  }
  return catalog_;
}

absl::StatusOr<FilterMasks::Pointer> FilterMasks::Of(const SnapshotPointer& snapshot,
                                                     const Catalog& catalog, const Filter& filter) {
  if (filter.passes_all()) return Pointer();
  const MutexLock lock(mutex_);
  std::erase_if(entries_, [](const Entry& entry) { return entry.snapshot.expired(); });
  const auto known = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.snapshot.lock() == snapshot && entry.filter == filter.text();
  });
  if (known != entries_.end()) {
    std::rotate(known, known + 1, entries_.end());
  } else {
    if (entries_.size() == kMaxMasks) entries_.erase(entries_.begin());
    entries_.push_back({snapshot, filter.text(), -1, {}, nullptr});
  }
  Entry& entry = entries_.back();
  if (entry.revision == catalog.revision()) return entry.mask;
  std::vector<bool> allowed;
  allowed.reserve(snapshot->model.clips().size());
  for (const core::ModelClip& clip : snapshot->model.clips()) {
    const CatalogClip* const stored = catalog.Find(clip.id);
    allowed.push_back(stored != nullptr && filter.Passes(*stored));
  }
  if (entry.mask == nullptr || allowed != entry.allowed) {
    auto mask = core::ClipMask::Create(snapshot->model, allowed);
    if (!mask.ok()) {
      entries_.pop_back();
      return mask.status();
    }
    entry.mask = *std::move(mask);
    entry.allowed = std::move(allowed);
  }
  entry.revision = catalog.revision();
  return entry.mask;
}

namespace {

constexpr std::size_t kMaxSkeletons = 256;

}  // namespace

absl::StatusOr<std::shared_ptr<const core::Skeleton>> SkeletonCache::Get(
    const std::string& database, const std::string& skeleton) {
  const std::pair key(database, skeleton);
  int clear_count = 0;
  {
    const storage::MutexLock lock(mutex_);
    if (const auto kept = skeletons_.find(key); kept != skeletons_.end()) return kept->second;
    clear_count = clear_count_;
  }
  MOTIONDB_ASSIGN_OR_RETURN(core::Skeleton read, store_.GetSkeleton(database, skeleton));
  auto shared = std::make_shared<const core::Skeleton>(std::move(read));
  const storage::MutexLock lock(mutex_);
  // A skeleton that was read before a deletion must not be cached after it.
  if (clear_count != clear_count_) return shared;
  if (skeletons_.size() >= kMaxSkeletons) skeletons_.clear();
  skeletons_[key] = shared;
  return shared;
}

void SkeletonCache::Clear() {
  const storage::MutexLock lock(mutex_);
  skeletons_.clear();
  ++clear_count_;
}

}  // namespace motiondb::server
