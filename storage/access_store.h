// Interface of the storage of bearer tokens and the audit log, and the options of a write.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/execution.h"

namespace motiondb::storage {

struct AuditRecord;

// Options of a write to a store.
struct WriteOptions {
  // Audit entry, stored in the same transaction as the change. Null: no entry.
  const AuditRecord* audit = nullptr;
  // Polled while the change waits in the queue, not after it has begun. If it returns true, the
  // call returns CANCELLED and changes nothing.
  core::Cancelled cancelled;
  // Id of the database to change; 0: any of the given name. ABORTED if it was deleted and another
  // one has its name now.
  std::int64_t database_id = 0;
};

// All times are microseconds since the Unix epoch.

// Each role includes the permissions of the roles before it.
enum class Role { kReader = 1, kIngester = 2, kAdmin = 3 };

// A bearer token. Only a salted hash of its secret is stored.
struct TokenRecord {
  std::string id;  // not secret
  Role role = Role::kReader;
  std::string database;  // the only database that the token is valid for; empty: all
  std::string description;
  std::string salt;
  std::string secret_hash;
  std::int64_t create_time_us = 0;
  std::int64_t expire_time_us = 0;  // 0: never
  std::int64_t revoke_time_us = 0;  // 0: not revoked
};

// An attempted or completed change, or a backup.
struct AuditRecord {
  std::int64_t sequence = 0;  // increases with each entry; set by the store
  std::int64_t time_us = 0;
  std::string principal;
  std::string peer;
  std::string method;
  std::string resource;
  std::int32_t code = 0;  // canonical status code
  std::string request_id;
};

// Thread-safe. A call that changes something returns when the change is durable.
class AccessStore {
 public:
  virtual ~AccessStore() = default;

  // ALREADY_EXISTS if the id exists.
  virtual absl::Status AddToken(const TokenRecord& record, const WriteOptions& terms = {}) = 0;
  // NOT_FOUND if there is no such token.
  virtual absl::StatusOr<TokenRecord> GetToken(const std::string& id) = 0;
  // Returns at most `limit` tokens after the token `after` (empty: from the first), in order of
  // creation. NOT_FOUND if the token `after` does not exist.
  virtual absl::StatusOr<std::vector<TokenRecord>> ListTokens(const std::string& after,
                                                              int limit) = 0;
  // Returns the updated record. A token that is already revoked keeps its revoke time. NOT_FOUND
  // if there is no such token.
  virtual absl::StatusOr<TokenRecord> RevokeToken(const std::string& id, std::int64_t time_us,
                                                  const WriteOptions& terms = {}) = 0;

  // The last 100,000 entries are kept. `cancelled`: see WriteOptions.
  virtual absl::Status AddAuditRecord(const AuditRecord& record,
                                      const core::Cancelled& cancelled = {}) = 0;
  // Returns at most `limit` entries with a sequence below `before` (0: from the newest), newest
  // first.
  virtual absl::StatusOr<std::vector<AuditRecord>> ListAuditRecords(std::int64_t before,
                                                                    int limit) = 0;
};

}  // namespace motiondb::storage
