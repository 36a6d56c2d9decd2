// Events that are kept for the operator: corruption found since the start, and the audit log.
#pragma once

#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "core/motion/execution.h"
#include "storage/access_store.h"
#include "storage/mutex.h"
#include "storage/store_maintenance.h"

namespace motiondb::server {

// Corruption found since the start, for the health report.
class CorruptionLog {
 public:
  static constexpr std::size_t kLimit = 100;

  // Logs and records `corruption`, unless it is already recorded or the list has kLimit entries.
  void Note(const storage::Corruption& corruption);
  // In the order of discovery.
  std::vector<storage::Corruption> List() const;

 private:
  mutable storage::Mutex mutex_;
  std::vector<storage::Corruption> corruptions_ ABSL_GUARDED_BY(mutex_);
};

// Stores an entry of the audit log. If that fails, logs the whole entry and returns OK. Returns
// CANCELLED, without a log line, if `cancelled` returned true before the write began; the caller
// may retry.
absl::Status StoreAuditRecord(storage::AccessStore& store, const storage::AuditRecord& record,
                              const core::Cancelled& cancelled = {});

}  // namespace motiondb::server
