// An AccessStore in plain containers.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "storage/access_store.h"

namespace motiondb::tests {

class InMemoryAccessStore : public storage::AccessStore {
 public:
  absl::Status AddToken(const storage::TokenRecord& record,
                        const storage::WriteOptions& terms = {}) override;
  absl::StatusOr<storage::TokenRecord> GetToken(const std::string& id) override;
  absl::StatusOr<std::vector<storage::TokenRecord>> ListTokens(const std::string& after,
                                                               int limit) override;
  absl::StatusOr<storage::TokenRecord> RevokeToken(
      const std::string& id, std::int64_t time_us,
      const storage::WriteOptions& terms = {}) override;
  absl::Status AddAuditRecord(const storage::AuditRecord& record,
                              const core::Cancelled& cancelled = {}) override;
  absl::StatusOr<std::vector<storage::AuditRecord>> ListAuditRecords(std::int64_t before,
                                                                     int limit) override;

 private:
  // Adds the audit entry of `terms`, if there is one. REQUIRES: the caller holds the mutex.
  void Note(const storage::WriteOptions& terms);
  using Tokens = std::vector<storage::TokenRecord>;
  absl::StatusOr<Tokens::iterator> Find(const std::string& id);

  std::mutex mutex_;
  Tokens tokens_;                            // oldest first
  std::vector<storage::AuditRecord> audit_;  // oldest first, numbered from 1
};

}  // namespace motiondb::tests
