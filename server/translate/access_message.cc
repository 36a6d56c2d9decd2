#include "server/translate/access_message.h"

#include "core/motion/error.h"
#include "motiondb/v1/access.pb.h"
#include "server/engine/request_checks.h"
#include "server/translate/message_fields.h"
#include "server/translate/resource_name.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxDescriptionBytes = 200;
constexpr std::int64_t kMaxTtlSeconds = std::int64_t{100} * 365 * 24 * 3600;

absl::StatusOr<storage::Role> RoleFrom(v1::Role role) {
  switch (role) {
    case v1::ROLE_READER:
      return storage::Role::kReader;
    case v1::ROLE_INGESTER:
      return storage::Role::kIngester;
    case v1::ROLE_ADMIN:
      return storage::Role::kAdmin;
    default:
      return FieldViolation("token.role", "expected one of ROLE_READER, ROLE_INGESTER, ROLE_ADMIN");
  }
}

v1::Role ToProto(storage::Role role) {
  switch (role) {
    case storage::Role::kReader:
      return v1::ROLE_READER;
    case storage::Role::kIngester:
      return v1::ROLE_INGESTER;
    case storage::Role::kAdmin:
      return v1::ROLE_ADMIN;
  }
  return v1::ROLE_UNSPECIFIED;
}

absl::StatusOr<std::int64_t> TtlFrom(const google::protobuf::Duration& ttl) {
  const bool positive = ttl.seconds() >= 0 && ttl.nanos() >= 0 && ttl.nanos() <= 999'999'999 &&
                        (ttl.seconds() > 0 || ttl.nanos() >= 1000);
  if (!positive || ttl.seconds() > kMaxTtlSeconds) {
    return FieldViolation("ttl",
                          "expected a positive duration of at most 100 years, got {} s {} ns",
                          ttl.seconds(), ttl.nanos());
  }
  return ttl.seconds() * 1'000'000 + ttl.nanos() / 1000;
}

absl::StatusOr<std::int64_t> ExpireTimeFrom(const google::protobuf::Timestamp& time,
                                            std::int64_t now_us) {
  const std::int64_t now_seconds = now_us / 1'000'000;
  const bool valid = time.seconds() > now_seconds &&
                     time.seconds() <= now_seconds + kMaxTtlSeconds && time.nanos() >= 0 &&
                     time.nanos() <= 999'999'999;
  if (!valid) {
    return FieldViolation("token.expire_time",
                          "expected a time from the next second to 100 years from now, got {} s",
                          time.seconds());
  }
  return time.seconds() * 1'000'000 + time.nanos() / 1000;
}

}  // namespace

absl::StatusOr<NewTokenSpec> ParseCreateToken(const v1::CreateTokenRequest& request,
                                              std::int64_t now_us) {
  NewTokenSpec wanted;
  const v1::Token& token = request.token();
  MOTIONDB_ASSIGN_OR_RETURN(wanted.role, RoleFrom(token.role()));
  if (!token.database().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(wanted.database,
                              ParseDatabaseName("token.database", token.database()));
  }
  if (request.has_ttl()) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t ttl_us, TtlFrom(request.ttl()));
    wanted.expire_time_us = now_us + ttl_us;
  }
  if (token.has_expire_time()) {
    if (request.has_ttl())
      return FieldViolation("ttl", "expected ttl or token.expire_time, got both");
    MOTIONDB_ASSIGN_OR_RETURN(wanted.expire_time_us, ExpireTimeFrom(token.expire_time(), now_us));
  }
  MOTIONDB_RETURN_IF_ERROR(
      CheckPlainText("token.description", token.description(), kMaxDescriptionBytes));
  wanted.description = token.description();
  return wanted;
}

void SetToken(const storage::TokenRecord& record, v1::Token& message) {
  message.set_name(TokenName(record.id));
  message.set_role(ToProto(record.role));
  if (!record.database.empty()) message.set_database(DatabaseName(record.database));
  message.set_description(record.description);
  SetTimestamp(record.create_time_us, *message.mutable_create_time());
  if (record.expire_time_us != 0) {
    SetTimestamp(record.expire_time_us, *message.mutable_expire_time());
  }
  if (record.revoke_time_us != 0) {
    SetTimestamp(record.revoke_time_us, *message.mutable_revoke_time());
  }
}

void SetAuditEntry(const storage::AuditRecord& record, v1::AuditEntry& message) {
  message.set_sequence(record.sequence);
  SetTimestamp(record.time_us, *message.mutable_time());
  message.set_principal(text::SafeText(record.principal));
  message.set_peer(record.peer);
  message.set_method(record.method);
  message.set_resource(text::SafeText(record.resource));
  message.set_code(record.code);
  message.set_request_id(text::SafeText(record.request_id));
}

}  // namespace motiondb::server
