// Converts between records of the store and messages: tokens and the audit log.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "storage/access_store.h"

namespace motiondb::v1 {
class AuditEntry;
class CreateTokenRequest;
class Token;
}  // namespace motiondb::v1

namespace motiondb::server {

// A token to create.
struct NewTokenSpec {
  storage::Role role = storage::Role::kReader;
  std::string database;  // id; empty: all
  std::string description;
  std::int64_t expire_time_us = 0;  // since the Unix epoch; 0: never
};

// `now_us`: current time, microseconds since the Unix epoch. Returns INVALID_ARGUMENT with the
// field.
absl::StatusOr<NewTokenSpec> ParseCreateToken(const v1::CreateTokenRequest& request,
                                              std::int64_t now_us);

void SetToken(const storage::TokenRecord& record, v1::Token& message);
void SetAuditEntry(const storage::AuditRecord& record, v1::AuditEntry& message);

}  // namespace motiondb::server
