// Writes entries of the audit log.
#pragma once

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/access_store.h"

namespace motiondb::server {

// Stores an entry. If that fails, logs the whole entry and returns OK. Returns CANCELLED, without a
// log line, if `cancelled` returned true before the write began; the caller may retry.
absl::Status StoreAuditRecord(storage::AccessStore& store, const storage::AuditRecord& record,
                              const core::Cancelled& cancelled = {});

}  // namespace motiondb::server
