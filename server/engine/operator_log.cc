#include "server/engine/operator_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace motiondb::server {

void CorruptionLog::Note(const storage::Corruption& corruption) {
  const storage::MutexLock lock(mutex_);
  const bool known = std::ranges::any_of(corruptions_, [&](const storage::Corruption& other) {
    return other.resource == corruption.resource && other.description == corruption.description;
  });
  if (known || corruptions_.size() >= kLimit) return;
  corruptions_.push_back(corruption);
  spdlog::error("corruption found: {}{}{}", corruption.resource,
                corruption.resource.empty() ? "" : ": ", corruption.description);
}

std::vector<storage::Corruption> CorruptionLog::List() const {
  const storage::MutexLock lock(mutex_);
  return corruptions_;
}

absl::Status StoreAuditRecord(storage::AccessStore& store, const storage::AuditRecord& record,
                              const core::Cancelled& cancelled) {
  absl::Status stored = store.AddAuditRecord(record, cancelled);
  if (stored.ok() || absl::IsCancelled(stored)) return stored;
  // A read-only store keeps no entries: the log has them.
  spdlog::log(
      absl::IsFailedPrecondition(stored) ? spdlog::level::info : spdlog::level::err,
      "audit entry not stored: error='{}' method={} principal={} peer={} resource='{}' code={}",
      stored.ToString(), record.method, record.principal, record.peer, record.resource,
      record.code);
  return absl::OkStatus();
}

}  // namespace motiondb::server
