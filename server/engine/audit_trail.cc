#include "server/engine/audit_trail.h"

#include <spdlog/spdlog.h>

namespace motiondb::server {

absl::Status KeepAuditRecord(storage::AccessStore& store, const storage::AuditRecord& record,
                             const core::Cancelled& cancelled) {
  absl::Status kept = store.AddAuditRecord(record, cancelled);
  if (kept.ok() || absl::IsCancelled(kept)) return kept;
  // A store that is open read-only keeps none: the log has them.
  spdlog::log(absl::IsFailedPrecondition(kept) ? spdlog::level::info : spdlog::level::err,
              "the record of changes could not be kept ({}): {} by {} from {} on '{}', code {}",
              kept.ToString(), record.method, record.principal, record.peer, record.resource,
              record.code);
  return absl::OkStatus();
}

}  // namespace motiondb::server
