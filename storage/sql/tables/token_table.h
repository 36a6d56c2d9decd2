// Rows of the table `token`. The functions run in the caller's transaction.
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

}  // namespace motiondb::storage
