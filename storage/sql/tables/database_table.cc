#include "storage/sql/tables/database_table.h"

#include <utility>

#include "core/motion/error.h"
#include "storage/sql/tables/enum_text.h"

namespace motiondb::storage {
namespace {

// Returns a query for the columns that ToDatabaseRecord reads.
std::string SelectDatabases(std::string_view condition) {
  return fmt::format(
      "SELECT name, frame_rate_hz, min_frames, scaling, marker_set, marker_set_text, "
      "create_time_us, glitches, database_key FROM database WHERE deleted = 0 AND {}",
      condition);
}

absl::StatusOr<DatabaseRecord> ToDatabaseRecord(const Statement& row) {
  DatabaseRecord record;
  record.name = row.Text(0);
  record.settings.frame_rate_hz = row.Real(1);
  record.settings.min_frames = row.Integer<int>(2);
  MOTIONDB_ASSIGN_OR_RETURN(record.settings.scaling, FromText<core::Scaling>(row.Text(3)));
  record.marker_set = row.Text(4);
  record.marker_set_text = row.Text(5);
  record.create_time_us = row.Integer(6);
  MOTIONDB_ASSIGN_OR_RETURN(record.settings.glitches, FromText<core::GlitchPolicy>(row.Text(7)));
  record.id = row.Integer(8);
  return record;
}

absl::Status NoDatabase(const std::string& name) {
  return core::WithReason("DATABASE_NOT_FOUND",
                          core::NotFound("database '{}' does not exist", name));
}

absl::Status IsAnother() {
  return absl::AbortedError(
      "the database was deleted during the call, and another one has its name: try again");
}

// Names the database in ALREADY_EXISTS of a write.
absl::Status IfNameIsTaken(const std::string& name, const absl::Status& written) {
  if (!absl::IsAlreadyExists(written)) return written;
  return core::WithReason("DATABASE_EXISTS", absl::AlreadyExistsError(fmt::format(
                                                 "database '{}' already exists", name)));
}

}  // namespace

absl::Status InsertDatabase(Connection& connection, const DatabaseRecord& record) {
  const auto inserted = connection.Insert(
      "database_key",
      "INSERT INTO database (name, frame_rate_hz, min_frames, scaling, marker_set, "
      "marker_set_text, create_time_us, glitches) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
      record.name, record.settings.frame_rate_hz, record.settings.min_frames,
      ToText(record.settings.scaling), record.marker_set, record.marker_set_text,
      record.create_time_us, ToText(record.settings.glitches));
  MOTIONDB_RETURN_IF_ERROR(IfNameIsTaken(record.name, inserted.status()));
  return connection.SetRowChecksum("database", *inserted);
}

absl::StatusOr<DatabaseRecord> SelectDatabase(Connection& connection, const std::string& name) {
  Statement row = connection.Query(SelectDatabases("name = ?"), name);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoDatabase(name);
  return ToDatabaseRecord(row);
}

absl::StatusOr<std::vector<DatabaseRecord>> SelectDatabases(Connection& connection,
                                                            const Page& page) {
  Statement row =
      connection.Query(SelectDatabases("name > ? ORDER BY name LIMIT ?"), page.after, page.limit);
  std::vector<DatabaseRecord> records;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return records;
    MOTIONDB_ASSIGN_OR_RETURN(records.emplace_back(), ToDatabaseRecord(row));
  }
}

absl::StatusOr<std::vector<DatabaseState>> SelectDatabaseStates(Connection& connection) {
  Statement row = connection.Query(
      "SELECT name, database_key, revision, row_crc FROM database WHERE deleted = 0 ORDER BY name");
  std::vector<DatabaseState> states;
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return states;
    // The checksum of the row: of all its columns.
    states.push_back({row.Text(0), row.Integer(1), row.Integer(2), row.Integer(3)});
  }
}

absl::Status MarkDatabaseDeleted(Connection& connection, const std::string& name, std::int64_t id) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t key, FindDatabase(connection, name, id));
  // Frees the name. Names of existing databases contain no slash.
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE database SET deleted = 1, name = 'deleted/' || database_key "
                 "WHERE database_key = ?",
                 key)
          .Run());
  return connection.SetRowChecksum("database", key);
}

absl::Status ShowDatabase(Connection& connection, std::int64_t database_key,
                          const std::string& name) {
  const absl::Status shown = connection
                                 .Query(
                                     "UPDATE database SET deleted = 0, name = ? WHERE "
                                     "database_key = ? AND deleted = 1",
                                     name, database_key)
                                 .Run();
  MOTIONDB_RETURN_IF_ERROR(IfNameIsTaken(name, shown));
  return connection.SetRowChecksum("database", database_key);
}

absl::StatusOr<std::int64_t> FindDatabase(Connection& connection, const std::string& name,
                                          std::int64_t id) {
  Statement row = connection.Query(
      fmt::format("SELECT database_key FROM database WHERE name = ? AND deleted = 0{}",
                  connection.row_lock()),
      name);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NoDatabase(name);
  if (id != 0 && row.Integer(0) != id) return IsAnother();
  return row.Integer(0);
}

absl::Status CheckHasDatabase(Connection& connection, std::int64_t id) {
  Statement row =
      connection.Query("SELECT 1 FROM database WHERE database_key = ? AND deleted = 0", id);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? absl::OkStatus() : IsAnother();
}

absl::Status CheckHasNoDatabases(Connection& connection) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto count, connection.QueryInteger("SELECT count(*) FROM database WHERE deleted = 0"));
  if (count == 0) return absl::OkStatus();
  return core::FailedPrecondition(
      "the store already has databases ({}): restore a backup into an empty store", count);
}

absl::Status SetMarkerSetText(Connection& connection, std::int64_t database_key,
                              const std::string& text) {
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE database SET marker_set_text = ?1 WHERE database_key = ?2 AND "
                 "marker_set_text IN ('', ?1)",
                 text, database_key)
          .Run());
  if (connection.changes() == 0) {
    return core::FailedPrecondition("the database already has another marker set");
  }
  return connection.SetRowChecksum("database", database_key);
}

absl::Status UpdateMarkerSetText(Connection& connection, const std::string& database,
                                 const std::string& before, const std::string& text) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::int64_t database_key, FindDatabase(connection, database));
  MOTIONDB_RETURN_IF_ERROR(
      connection
          .Query("UPDATE database SET marker_set_text = ? WHERE database_key = ? AND "
                 "marker_set_text = ?",
                 text, database_key, before)
          .Run());
  if (connection.changes() == 0) {
    return absl::AbortedError(
        fmt::format("another call has changed the marker set of database '{}'", database));
  }
  return connection.SetRowChecksum("database", database_key);
}

}  // namespace motiondb::storage
