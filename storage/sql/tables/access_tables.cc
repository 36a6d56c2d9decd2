#include "storage/sql/tables/access_tables.h"

#include <limits>
#include <span>

#include "core/motion/error.h"
#include "storage/sql/tables/enum_text.h"

namespace motiondb::storage {
namespace {

// Returns a query for the columns that ToTokenRecord reads.
std::string SelectTokens(std::string_view condition) {
  return fmt::format(
      "SELECT id, role, database, description, salt, secret_hash, create_time_us, expire_time_us, "
      "revoke_time_us FROM token WHERE {}",
      condition);
}

std::string ToString(std::span<const std::byte> blob) {
  return {reinterpret_cast<const char*>(blob.data()), blob.size()};
}

absl::StatusOr<TokenRecord> ToTokenRecord(const Statement& row) {
  TokenRecord record;
  record.id = row.Text(0);
  MOTIONDB_ASSIGN_OR_RETURN(record.role, FromText<Role>(row.Text(1)));
  record.database = row.Text(2);
  record.description = row.Text(3);
  record.salt = ToString(row.Blob(4));
  record.secret_hash = ToString(row.Blob(5));
  record.create_time_us = row.Integer(6);
  record.expire_time_us = row.Integer(7);
  record.revoke_time_us = row.Integer(8);
  return record;
}

absl::Status NoToken(const std::string& id) {
  return core::WithReason("TOKEN_NOT_FOUND", core::NotFound("token '{}' does not exist", id));
}

}  // namespace

absl::Status InsertToken(Connection& connection, const TokenRecord& record) {
  const auto inserted = connection.Insert(
      "sequence",
      "INSERT INTO token (id, role, database, description, salt, secret_hash, "
      "create_time_us, expire_time_us, revoke_time_us) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
      record.id, ToText(record.role), record.database, record.description,
      std::as_bytes(std::span(record.salt)), std::as_bytes(std::span(record.secret_hash)),
      record.create_time_us, record.expire_time_us, record.revoke_time_us);
  if (absl::IsAlreadyExists(inserted.status())) {
    return absl::AlreadyExistsError(fmt::format("token '{}' already exists", record.id));
  }
  MOTIONDB_RETURN_IF_ERROR(inserted.status());
  return connection.SetRowChecksum("token", *inserted);
}

absl::StatusOr<TokenRecord> SelectToken(Connection& connection, const std::string& id) {
  Statement row = connection.Query(SelectTokens("id = ?"), id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoToken(id);
  return ToTokenRecord(row);
}

absl::StatusOr<std::vector<TokenRecord>> SelectTokens(Connection& connection,
                                                      const std::string& after, int limit) {
  std::int64_t above = 0;
  if (!after.empty()) {
    Statement row = connection.Query("SELECT sequence FROM token WHERE id = ?", after);
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return NoToken(after);
    above = row.Integer(0);
  }
  Statement row =
      connection.Query(SelectTokens("sequence > ? ORDER BY sequence LIMIT ?"), above, limit);
  std::vector<TokenRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToTokenRecord(row));
  }
}

absl::StatusOr<TokenRecord> MarkTokenRevoked(Connection& connection, const std::string& id,
                                             std::int64_t time_us) {
  Statement revoke = connection.Query(
      "UPDATE token SET revoke_time_us = ? WHERE id = ? AND revoke_time_us = 0 RETURNING sequence",
      time_us, id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool revoked, revoke.Step());
  if (revoked) {
    const std::int64_t sequence = revoke.Integer(0);
    MOTIONDB_RETURN_IF_ERROR(revoke.Run());
    MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("token", sequence));
  }
  return SelectToken(connection, id);
}

absl::Status InsertAuditRecord(Connection& connection, const AuditRecord& record) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const std::int64_t sequence,
      connection.Insert(
          "sequence",
          "INSERT INTO audit (time_us, principal, peer, method, resource, code, request_id) "
          "VALUES (?, ?, ?, ?, ?, ?, ?)",
          record.time_us, record.principal, record.peer, record.method, record.resource,
          record.code, record.request_id));
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("audit", sequence));
  // Sequence numbers have no gaps, so exactly kAuditLimit rows stay.
  return connection.Query("DELETE FROM audit WHERE sequence <= ?", sequence - kAuditLimit)
      .RunLater();
}

absl::StatusOr<std::vector<AuditRecord>> SelectAuditRecords(Connection& connection,
                                                            std::int64_t before, int limit) {
  if (before == 0) before = std::numeric_limits<std::int64_t>::max();
  Statement row = connection.Query(
      "SELECT sequence, time_us, principal, peer, method, resource, code, request_id FROM audit "
      "WHERE sequence < ? ORDER BY sequence DESC LIMIT ?",
      before, limit);
  std::vector<AuditRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    AuditRecord& record = records.emplace_back();
    record.sequence = row.Integer(0);
    record.time_us = row.Integer(1);
    record.principal = row.Text(2);
    record.peer = row.Text(3);
    record.method = row.Text(4);
    record.resource = row.Text(5);
    record.code = row.Integer<std::int32_t>(6);
    record.request_id = row.Text(7);
  }
}

}  // namespace motiondb::storage
