// Checks a PostgreSQL store: SqlVerifier, without the files of PostgreSQL, which pg_amcheck and
// page checksums check.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "storage/sql/sql_verifier.h"

namespace motiondb::storage {

class PostgresVerifier final : public SqlVerifier {
 public:
  using SqlVerifier::SqlVerifier;

 private:
  absl::Status CheckSchema(Connection& connection) override;
  absl::Status CheckFile(Connection& connection, std::int64_t& size) override;
  absl::Status CheckSearchIndex(Connection& connection) override;
  absl::Status CheckText(Connection& connection, std::int64_t clip_key,
                         const ClipText& text) override;
  absl::StatusOr<std::vector<ChangedRow>> FindChanged(Connection& connection,
                                                      std::string_view table) override;
};

}  // namespace motiondb::storage
