// Messages of AccessService <-> records. Safe to call from any thread.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "storage/access_store.h"

namespace motiondb::v1 {
class AuditEntry;
class CreateTokenRequest;
class Token;
}  // namespace motiondb::v1

namespace motiondb::server {

// What is to be made. Times, id and hash are left empty, except for how long it is good.
struct WantedToken {
  storage::Role role = storage::Role::kReader;
  std::string database;  // its id; empty: all
  std::string description;
  std::int64_t lifetime_us = 0;  // 0: for ever
};

// INVALID_ARGUMENT, naming the field.
absl::StatusOr<WantedToken> WantedFrom(const v1::CreateTokenRequest& request);

void SetToken(const storage::TokenRecord& record, v1::Token& message);
void SetAuditEntry(const storage::AuditRecord& record, v1::AuditEntry& message);

}  // namespace motiondb::server
