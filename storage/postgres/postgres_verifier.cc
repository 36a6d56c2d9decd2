#include "storage/postgres/postgres_verifier.h"

#include <algorithm>

#include "core/motion/error.h"
#include "storage/postgres/schema.h"

namespace motiondb::storage {

absl::Status PostgresVerifier::CheckSchema(Connection& connection) {
  return CheckPostgresVersion(connection);
}

absl::Status PostgresVerifier::CheckFile(Connection& connection, std::int64_t& size) {
  MOTIONDB_ASSIGN_OR_RETURN(
      const auto bytes,
      connection.QueryInteger("SELECT COALESCE(sum(pg_total_relation_size(oid)), 0)::bigint FROM "
                              "pg_class WHERE oid IN ('clip_chunk'::regclass, "
                              "'model_chunk'::regclass, 'skeleton_chunk'::regclass)"));
  size = std::max<std::int64_t>(1, bytes);
  return absl::OkStatus();
}

absl::Status PostgresVerifier::CheckSearchIndex(Connection& connection) {
  Statement row = connection.Query(
      "SELECT 'databases/' || name || '/clips/' || id FROM clip_text JOIN clip ON clip_key = rowid "
      "JOIN database USING (database_key) WHERE words IS DISTINCT FROM "
      "motiondb_lexemes(clip_text.title || ' ' || clip_text.description || ' ' || tags || ' ' || "
      "labels || ' ' || clip_text.subject || ' ' || clip_text.file_name) LIMIT 100");
  while (true) {
    const auto found = row.Step();
    if (!found.ok()) return Note("", In("the search index", found.status()));
    if (!*found) return absl::OkStatus();
    MOTIONDB_RETURN_IF_ERROR(
        Note(row.Text(0), core::DataLoss("search index: its words differ from the clip")));
  }
}

absl::Status PostgresVerifier::CheckText(Connection& connection, std::int64_t clip_key,
                                         const ClipText& text) {
  Statement row = connection.Query(
      "SELECT title, description, tags, labels, subject, file_name FROM clip_text WHERE rowid = ?",
      clip_key);
  MOTIONDB_ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return core::DataLoss("search index: the clip is missing");
  for (std::size_t f = 0; f < text.size(); ++f) {
    if (row.Text(static_cast<int>(f)) != text[f]) {
      return core::DataLoss("search index: its text differs from the clip");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<ChangedRow>> PostgresVerifier::FindChanged(Connection& connection,
                                                                      std::string_view table) {
  return FindRows(connection, table, connection.RowIsChanged(table));
}

}  // namespace motiondb::storage
