// Rows of the table `audit`. The functions run in the caller's transaction.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Number of entries to keep; older ones are deleted.
inline constexpr int kAuditLimit = 100'000;

// See AccessStore::AddAuditRecord and ListAuditRecords.
absl::Status InsertAuditRecord(Connection& connection, const AuditRecord& record);
absl::StatusOr<std::vector<AuditRecord>> SelectAuditRecords(Connection& connection,
                                                            std::int64_t before, int limit);

}  // namespace motiondb::storage
