#include "storage/sql/tables/operation_table.h"

#include <algorithm>
#include <limits>

#include "core/motion/error.h"
#include "storage/sql/tables/database_table.h"
#include "storage/sql/tables/enum_text.h"

namespace motiondb::storage {
namespace {

constexpr int kOperationsKept = 1000;  // finished operations to keep, per database

// Returns a query for the columns that ToOperationRecord reads.
std::string SelectOperations(std::string_view condition) {
  return fmt::format(
      "SELECT id, name, state, progress, stage, model_version, error_code, error_message, "
      "operation.create_time_us, update_time_us, kind, database_key FROM operation JOIN database "
      "USING (database_key) WHERE deleted = 0 AND {}",
      condition);
}

absl::StatusOr<OperationRecord> ToOperationRecord(const Statement& row) {
  OperationRecord record;
  record.id = row.Text(0);
  record.database = row.Text(1);
  MOTIONDB_ASSIGN_OR_RETURN(record.state, FromText<OperationState>(row.Text(2)));
  record.progress = row.Real(3);
  record.stage = row.Text(4);
  record.model_version = row.Integer<std::int32_t>(5);
  record.error_code = row.Integer<std::int32_t>(6);
  record.error_message = row.Text(7);
  record.create_time_us = row.Integer(8);
  record.update_time_us = row.Integer(9);
  MOTIONDB_ASSIGN_OR_RETURN(record.kind, FromText<OperationKind>(row.Text(10)));
  record.database_id = row.Integer(11);
  return record;
}

absl::Status NoOperation(const std::string& id) {
  return core::WithReason("OPERATION_NOT_FOUND",
                          core::NotFound("operation '{}' does not exist", id));
}

// Deletes old finished operations of a database.
absl::Status ForgetOldOperations(Connection& connection, std::int64_t database_key) {
  return connection
      .Query(
          "DELETE FROM operation WHERE database_key = ? AND state IN ('succeeded', 'failed', "
          "'cancelled') AND sequence <= (SELECT sequence FROM operation WHERE database_key = ? "
          "ORDER BY sequence DESC LIMIT 1 OFFSET ?)",
          database_key, database_key, kOperationsKept)
      .Run();
}

// Returns the sequence number of the operation `before`; the maximum if it is empty.
absl::StatusOr<std::int64_t> SequenceOf(Connection& connection, const std::string& before) {
  if (before.empty()) return std::numeric_limits<std::int64_t>::max();
  Statement row = connection.Query(
      "SELECT sequence FROM operation JOIN database USING (database_key) WHERE deleted = 0 AND "
      "id = ?",
      before);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoOperation(before);
  return row.Integer(0);
}

// Reads the rows that remain.
absl::StatusOr<std::vector<OperationRecord>> ToOperationRecords(Statement& row) {
  std::vector<OperationRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToOperationRecord(row));
  }
}

// ABORTED if the operation has ended. NOT_FOUND if it belongs to another database: a former one,
// which was deleted, with the same name.
absl::Status CheckMayChange(Connection& connection, const std::string& id,
                            std::int64_t database_key) {
  Statement row = connection.Query("SELECT state, database_key FROM operation WHERE id = ?", id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return absl::OkStatus();
  if (row.Integer(1) != database_key) return NoOperation(id);
  MOTIONDB_ASSIGN_OR_RETURN(const auto stored, FromText<OperationState>(row.Text(0)));
  if (stored < OperationState::kSucceeded) return absl::OkStatus();
  return absl::AbortedError(fmt::format("operation '{}' has already ended: {}", id, row.Text(0)));
}

}  // namespace

absl::Status UpsertOperation(Connection& connection, const OperationRecord& record) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key,
                            FindDatabase(connection, record.database));
  MOTIONDB_RETURN_IF_ERROR(CheckMayChange(connection, record.id, database_key));
  if (record.database_id != 0 && record.database_id != database_key) {
    return FindDatabase(connection, record.database, record.database_id).status();
  }
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("INSERT INTO operation (id, database_key, state, progress, stage, model_version, "
                 "error_code, error_message, create_time_us, update_time_us, kind) "
                 "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE SET "
                 "(state, progress, stage, model_version, error_code, error_message, "
                 "create_time_us, update_time_us) = (excluded.state, excluded.progress, "
                 "excluded.stage, excluded.model_version, excluded.error_code, "
                 "excluded.error_message, excluded.create_time_us, excluded.update_time_us)",
                 record.id, database_key, ToText(record.state), record.progress, record.stage,
                 record.model_version, record.error_code, record.error_message,
                 record.create_time_us, record.update_time_us, ToText(record.kind))
          .Run());
  // Not with a RETURNING clause, which would need a statement journal.
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t sequence, SequenceOf(connection, record.id));
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("operation", sequence));
  if (record.state != OperationState::kPending) return absl::OkStatus();
  return ForgetOldOperations(connection, database_key);
}

absl::StatusOr<OperationRecord> SelectOperation(Connection& connection, const std::string& id) {
  Statement row = connection.Query(SelectOperations("id = ?"), id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoOperation(id);
  return ToOperationRecord(row);
}

absl::StatusOr<std::vector<OperationRecord>> SelectOperations(Connection& connection,
                                                              const std::string& database,
                                                              const std::string& before,
                                                              int limit) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t below, SequenceOf(connection, before));
  Statement row = connection.Query(
      SelectOperations(database.empty()
                           ? "sequence < ? ORDER BY sequence DESC LIMIT ?"
                           : "sequence < ? AND database_key = ?3 ORDER BY sequence DESC LIMIT ?2"),
      below, limit);
  if (!database.empty()) {
    MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
    row.Bind(database_key);
  }
  return ToOperationRecords(row);
}

absl::StatusOr<std::vector<OperationRecord>> SelectUnfinishedOperations(Connection& connection) {
  Statement row =
      connection.Query(SelectOperations("state IN ('pending', 'running') ORDER BY sequence"));
  return ToOperationRecords(row);
}

namespace {

struct LeaseRow {
  std::string holder;      // empty: released
  std::int64_t fence = 0;  // 0: there is no row
  std::int64_t expire_time_us = 0;
};

absl::StatusOr<LeaseRow> SelectLease(Connection& connection, std::int64_t database_key) {
  Statement row = connection.Query(
      "SELECT holder, fence, expire_time_us FROM build_lease WHERE database_key = ?", database_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return LeaseRow{};
  return LeaseRow{row.Text(0), row.Integer(1), row.Integer(2)};
}

// Fencing numbers begin with the key of their database, so that those of a deleted database are not
// valid for another one with its name.
constexpr int kFenceBits = 32;

std::int64_t NextFence(std::int64_t database_key, std::int64_t last_fence) {
  return std::max(last_fence, database_key << kFenceBits) + 1;
}

absl::Status LeaseIsLost(const LeaseRow& last, std::int64_t fence) {
  return absl::AbortedError(
      last.holder.empty()
          ? fmt::format("build lease {} has ended; the last one was {}", fence, last.fence)
          : fmt::format("build lease {} has ended; '{}' has lease {}", fence, last.holder,
                        last.fence));
}

// Sets the lease `fence`, if it is the last one and was not released. Returns whether it was.
absl::StatusOr<bool> SetLease(Connection& connection, std::int64_t database_key, std::int64_t fence,
                              const char* change, std::int64_t value) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query(fmt::format("UPDATE build_lease SET {} WHERE database_key = ? AND fence = ? AND "
                             "holder <> ''",
                             change),
                 value, database_key, fence)
          .Run());
  if (connection.changes() == 0) return false;
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("build_lease", database_key));
  return true;
}

}  // namespace

absl::StatusOr<std::int64_t> AcquireLease(Connection& connection, std::int64_t database_key,
                                          const std::string& holder, std::int64_t now_us,
                                          std::int64_t expire_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  const bool is_free =
      last.holder.empty() || last.holder == holder || last.expire_time_us <= now_us;
  if (!is_free) {
    return absl::AbortedError(fmt::format("'{}' has the build lease of the database", last.holder));
  }
  const std::int64_t fence = NextFence(database_key, last.fence);
  const char* const sql =
      last.fence == 0
          ? "INSERT INTO build_lease (holder, fence, expire_time_us, database_key) VALUES (?, ?, "
            "?, ?)"
          : "UPDATE build_lease SET holder = ?, fence = ?, expire_time_us = ? WHERE database_key "
            "= ?";
  MOTIONDB_RETURN_IF_ERROR(
      connection.Query(sql, holder, fence, expire_time_us, database_key).Run());
  MOTIONDB_RETURN_IF_ERROR(connection.SetRowChecksum("build_lease", database_key));
  return fence;
}

absl::Status RenewLease(Connection& connection, std::int64_t database_key, std::int64_t fence,
                        std::int64_t expire_time_us) {
  MOTIONDB_ASSIGN_OR_RETURN(const bool renewed, SetLease(connection, database_key, fence,
                                                         "expire_time_us = ?", expire_time_us));
  if (renewed) return absl::OkStatus();
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  return LeaseIsLost(last, fence);
}

absl::Status ReleaseLease(Connection& connection, std::int64_t database_key, std::int64_t fence) {
  return SetLease(connection, database_key, fence, "holder = '', expire_time_us = ?", 0).status();
}

absl::Status CheckFence(Connection& connection, std::int64_t database_key, std::int64_t fence) {
  MOTIONDB_ASSIGN_OR_RETURN(const LeaseRow last, SelectLease(connection, database_key));
  const bool is_of_another = fence != 0 && fence >> kFenceBits != database_key;
  return fence < last.fence || is_of_another ? LeaseIsLost(last, fence) : absl::OkStatus();
}

}  // namespace motiondb::storage
