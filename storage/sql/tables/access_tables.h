// Rows of the tables `token` and `audit`. The functions run in the caller's transaction.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// See AccessStore::AddToken, GetToken, ListTokens and RevokeToken.
absl::Status InsertToken(Connection& connection, const TokenRecord& record);
absl::StatusOr<TokenRecord> SelectToken(Connection& connection, const std::string& id);
absl::StatusOr<std::vector<TokenRecord>> SelectTokens(Connection& connection,
                                                      const std::string& after, int limit);
absl::StatusOr<TokenRecord> MarkTokenRevoked(Connection& connection, const std::string& id,
                                             std::int64_t time_us);

// Number of audit entries to keep; older ones are deleted.
inline constexpr int kAuditLimit = 100'000;

// See AccessStore::AddAuditRecord and ListAuditRecords.
absl::Status InsertAuditRecord(Connection& connection, const AuditRecord& record);
absl::StatusOr<std::vector<AuditRecord>> SelectAuditRecords(Connection& connection,
                                                            std::int64_t before, int limit);

}  // namespace motiondb::storage
