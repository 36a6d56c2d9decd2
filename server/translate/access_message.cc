#include "server/translate/access_message.h"

#include "core/motion/error.h"
#include "motiondb/v1/access.pb.h"
#include "server/translate/field_violation.h"
#include "server/translate/plain_text.h"
#include "server/translate/resource_name.h"
#include "server/translate/timestamp.h"
#include "text/display_text.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kLongestDescription = 200;
constexpr std::int64_t kLongestLifetimeSeconds = std::int64_t{100} * 365 * 24 * 3600;

absl::StatusOr<storage::Role> RoleFrom(v1::Role role) {
  switch (role) {
    case v1::ROLE_READER:
      return storage::Role::kReader;
    case v1::ROLE_INGESTER:
      return storage::Role::kIngester;
    case v1::ROLE_ADMIN:
      return storage::Role::kAdmin;
    default:
      return FieldViolation("role", "expected one of ROLE_READER, ROLE_INGESTER, ROLE_ADMIN");
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

absl::StatusOr<std::int64_t> LifetimeFrom(const google::protobuf::Duration& lifetime) {
  const bool positive = lifetime.seconds() >= 0 && lifetime.nanos() >= 0 &&
                        lifetime.nanos() <= 999'999'999 &&
                        (lifetime.seconds() > 0 || lifetime.nanos() >= 1000);
  if (!positive || lifetime.seconds() > kLongestLifetimeSeconds) {
    return FieldViolation("lifetime",
                          "expected a positive duration of at most a hundred years, got {} s {} ns",
                          lifetime.seconds(), lifetime.nanos());
  }
  return lifetime.seconds() * 1'000'000 + lifetime.nanos() / 1000;
}

}  // namespace

absl::StatusOr<WantedToken> WantedFrom(const v1::CreateTokenRequest& request) {
  WantedToken wanted;
  MOTIONDB_ASSIGN_OR_RETURN(wanted.role, RoleFrom(request.role()));
  if (!request.database().empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(wanted.database, ParseDatabaseName("database", request.database()));
  }
  if (request.has_lifetime()) {
    MOTIONDB_ASSIGN_OR_RETURN(wanted.lifetime_us, LifetimeFrom(request.lifetime()));
  }
  MOTIONDB_RETURN_IF_ERROR(
      CheckPlainText("description", request.description(), kLongestDescription));
  wanted.description = request.description();
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
