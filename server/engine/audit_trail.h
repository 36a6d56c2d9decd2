// Writes entries of the record of changes.
#pragma once

#include "absl/status/status.h"
#include "core/motion/cancellation.h"
#include "storage/access_store.h"

namespace motiondb::server {

// Keeps an entry; logs it whole where that fails. CANCELLED, and nothing else, where it was
// cancelled before its turn to be written: nothing is logged, and it may be tried again. Safe to
// call from any thread.
absl::Status KeepAuditRecord(storage::AccessStore& store, const storage::AuditRecord& record,
                             const core::Cancelled& cancelled = {});

}  // namespace motiondb::server
