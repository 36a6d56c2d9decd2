#include "storage/sql/tables/audit_table.h"

#include <limits>

#include "core/motion/error.h"

namespace motiondb::storage {

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
