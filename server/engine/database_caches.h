// What is kept in memory of stored databases, besides their models. Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/model/clip_mask.h"
#include "core/motion/motion.h"
#include "server/engine/snapshot.h"
#include "server/filter/catalog.h"
#include "server/filter/filter.h"
#include "storage/annotation_store.h"
#include "storage/motion_store.h"
#include "storage/mutex.h"

namespace motiondb::server {

// The catalog of one database as stored now.
class DatabaseCatalog {
 public:
  using Pointer = std::shared_ptr<const Catalog>;

  // Returns the catalog with all changes that are stored when the call begins. Costs one read of
  // the revision, and a read of the changes since the last call. NOT_FOUND, DATA_LOSS.
  absl::StatusOr<Pointer> Current(storage::AnnotationStore& store, const std::string& database);

 private:
  storage::Mutex mutex_;  // held while changes are read, so that they are read once
  Pointer catalog_ ABSL_GUARDED_BY(mutex_) = std::make_shared<const Catalog>();
};

// Masks of the last filters, made from the catalog, because their graphs cost more than a query.
class FilterMasks {
 public:
  using Pointer = std::shared_ptr<const core::ClipMask>;

  // Returns the mask of those clips of the model that are in the catalog and pass the filter; null
  // if the filter passes all. FAILED_PRECONDITION with reason FILTER_MATCHES_NOTHING. The mask
  // refers to the snapshot.
  absl::StatusOr<Pointer> Of(const SnapshotPointer& snapshot, const Catalog& catalog,
                             const Filter& filter);

 private:
  struct Entry {
    std::weak_ptr<const Snapshot> snapshot;
    std::string filter;
    std::int64_t revision = 0;  // of the catalog
    std::vector<bool> allowed;
    Pointer mask;
  };

  storage::Mutex mutex_;
  std::vector<Entry> entries_ ABSL_GUARDED_BY(mutex_);  // the last used is the last
};

// Cache of the skeletons that observations reference.
class SkeletonCache {
 public:
  // The store must outlive the cache.
  explicit SkeletonCache(storage::MotionStore& store) : store_(store) {}

  // NOT_FOUND.
  absl::StatusOr<std::shared_ptr<const core::Skeleton>> Get(const std::string& database,
                                                            const std::string& skeleton);
  // Drops all entries. Called after a deletion, which may have deleted skeletons.
  void Clear();

 private:
  storage::MotionStore& store_;
  storage::Mutex mutex_;
  std::map<std::pair<std::string, std::string>, std::shared_ptr<const core::Skeleton>> skeletons_
      ABSL_GUARDED_BY(mutex_);
  int clear_count_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace motiondb::server
