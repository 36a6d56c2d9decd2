// Rows of the table `token`. Functions keep no state; they run in the transaction of their caller.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/access_store.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// As AccessStore::AddToken, GetToken, ListTokens and RevokeToken.
absl::Status InsertToken(Connection& connection, const TokenRecord& record);
absl::StatusOr<TokenRecord> SelectToken(Connection& connection, const std::string& id);
absl::StatusOr<std::vector<TokenRecord>> SelectTokens(Connection& connection,
                                                      const std::string& after, int limit);
absl::StatusOr<TokenRecord> MarkTokenRevoked(Connection& connection, const std::string& id,
                                             std::int64_t time_us);

}  // namespace motiondb::storage
