// Where bearer tokens and the record of changes are kept, beside the motion, and on what terms a
// store is changed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/motion/cancellation.h"

namespace motiondb::storage {

// On what terms something in a store is changed.
struct AuditRecord;

struct ChangeTerms {
  // The entry in the record of changes: kept with the change, or neither is. Null: there is none.
  const AuditRecord* audit = nullptr;
  // Asked while the change waits for its turn, and not once it is being made: CANCELLED, with
  // nothing changed.
  core::Cancelled cancelled;
};

// Where bearer tokens and the record of changes are kept, beside the motion. Implementations are
// safe to call from any thread; a call that changes something returns when the change is durable.
// Times are microseconds since the Unix epoch.

// Each may do what those before it may.
enum class Role { kReader = 1, kIngester = 2, kAdmin = 3 };

// A bearer token without its secret, of which only a salted hash is kept.
struct TokenRecord {
  std::string id;  // no secret
  Role role = Role::kReader;
  std::string database;  // the one it is good for; empty: all
  std::string description;
  std::string salt;
  std::string secret_hash;
  std::int64_t create_time_us = 0;
  std::int64_t expire_time_us = 0;  // 0: never
  std::int64_t revoke_time_us = 0;  // 0: it is good
};

// One change that was made, or tried; or a copy of the whole store that was taken.
struct AuditRecord {
  std::int64_t sequence = 0;  // rises with each entry; given by the store
  std::int64_t time_us = 0;
  std::string principal;
  std::string peer;
  std::string method;
  std::string resource;
  std::int32_t code = 0;  // canonical status code
  std::string request_id;
};

class AccessStore {
 public:
  virtual ~AccessStore() = default;

  // ALREADY_EXISTS if the id is taken.
  virtual absl::Status AddToken(const TokenRecord& record, const ChangeTerms& terms = {}) = 0;
  // NOT_FOUND.
  virtual absl::StatusOr<TokenRecord> GetToken(const std::string& id) = 0;
  // In the order in which they were made: those after the token `after` (empty: from the first), at
  // most `limit`. NOT_FOUND if there is no token `after`.
  virtual absl::StatusOr<std::vector<TokenRecord>> ListTokens(const std::string& after,
                                                              int limit) = 0;
  // The record as it then stands; one that was revoked keeps its time. NOT_FOUND.
  virtual absl::StatusOr<TokenRecord> RevokeToken(const std::string& id, std::int64_t time_us,
                                                  const ChangeTerms& terms = {}) = 0;

  // The last hundred thousand entries are kept. `cancelled` as ChangeTerms has it.
  virtual absl::Status AddAuditRecord(const AuditRecord& record,
                                      const core::Cancelled& cancelled = {}) = 0;
  // Newest first: those of a lower sequence than `before` (0: from the newest), at most `limit`.
  virtual absl::StatusOr<std::vector<AuditRecord>> ListAuditRecords(std::int64_t before,
                                                                    int limit) = 0;
};

}  // namespace motiondb::storage
