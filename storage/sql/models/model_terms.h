// Checks of ModelTerms, in the caller's transaction.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "storage/records.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/deleted_databases.h"

namespace motiondb::storage {

// ABORTED if a condition is not met. `database_key`: found by FindDatabase in this transaction.
absl::Status CheckModelTerms(Connection& connection, const std::string& database,
                             std::int64_t database_key, const ModelTerms& terms);

// Runs pieces as `write`, each only if `fence` is not outdated (ModelTerms::fence). The arguments
// must outlive the result.
TransactionRunner Fenced(const TransactionRunner& write, const std::string& database,
                         std::int64_t fence);

}  // namespace motiondb::storage
