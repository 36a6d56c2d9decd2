// Rows of the table `audit`. Functions keep no state; they run in the transaction of their caller.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// Entries that are kept; the oldest go.
inline constexpr int kAuditLimit = 100'000;

// As AccessStore::AddAuditRecord and ListAuditRecords.
absl::Status InsertAuditRecord(Connection& connection, const AuditRecord& record);
absl::StatusOr<std::vector<AuditRecord>> SelectAuditRecords(Connection& connection,
                                                            std::int64_t before, int limit);

}  // namespace motiondb::storage
