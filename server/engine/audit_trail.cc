#include "server/engine/audit_trail.h"

#include <spdlog/spdlog.h>

namespace motiondb::server {

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
