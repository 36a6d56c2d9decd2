#include "tests/storage/conformance/in_memory_access_store.h"

#include <algorithm>

#include "core/motion/error.h"

namespace motiondb::tests {

using storage::AuditRecord;
using storage::TokenRecord;

absl::StatusOr<InMemoryAccessStore::Tokens::iterator> InMemoryAccessStore::Find(
    const std::string& id) {
  const auto found = std::ranges::find(tokens_, id, &TokenRecord::id);
  if (found == tokens_.end()) return core::NotFound("token '{}' does not exist", id);
  return found;
}

void InMemoryAccessStore::Note(const storage::WriteOptions& terms) {
  if (terms.audit == nullptr) return;
  audit_.push_back(*terms.audit);
  audit_.back().sequence = static_cast<std::int64_t>(audit_.size());
}

absl::Status InMemoryAccessStore::AddToken(const TokenRecord& record,
                                           const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  if (Find(record.id).ok()) {
    return absl::AlreadyExistsError(fmt::format("token '{}' already exists", record.id));
  }
  tokens_.push_back(record);
  Note(terms);
  return absl::OkStatus();
}

absl::StatusOr<TokenRecord> InMemoryAccessStore::GetToken(const std::string& id) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const auto found, Find(id));
  return *found;
}

absl::StatusOr<std::vector<TokenRecord>> InMemoryAccessStore::ListTokens(const std::string& after,
                                                                         int limit) {
  const std::lock_guard lock(mutex_);
  auto first = tokens_.begin();
  if (!after.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(first, Find(after));
    ++first;
  }
  return Tokens(first, first + std::min<std::ptrdiff_t>(limit, tokens_.end() - first));
}

absl::StatusOr<TokenRecord> InMemoryAccessStore::RevokeToken(const std::string& id,
                                                             std::int64_t time_us,
                                                             const storage::WriteOptions& terms) {
  const std::lock_guard lock(mutex_);
  MOTIONDB_ASSIGN_OR_RETURN(const auto found, Find(id));
  if (found->revoke_time_us == 0) found->revoke_time_us = time_us;
  Note(terms);
  return *found;
}

absl::Status InMemoryAccessStore::AddAuditRecord(const AuditRecord& record,
                                                 const core::Cancelled&) {
  const std::lock_guard lock(mutex_);
  Note({&record});
  return absl::OkStatus();
}

absl::StatusOr<std::vector<AuditRecord>> InMemoryAccessStore::ListAuditRecords(std::int64_t before,
                                                                               int limit) {
  const std::lock_guard lock(mutex_);
  std::vector<AuditRecord> records;
  for (auto it = audit_.rbegin(); it != audit_.rend(); ++it) {
    if (static_cast<int>(records.size()) == limit) break;
    if (before == 0 || it->sequence < before) records.push_back(*it);
  }
  return records;
}

}  // namespace motiondb::tests
