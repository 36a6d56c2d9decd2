#include "storage/sql/tables/clip_text.h"

#include <vector>

#include "core/motion/error.h"
#include "storage/blob/annotation_codec.h"

namespace motiondb::storage {

absl::Status InsertClipText(Connection& connection, std::int64_t clip_key, const ClipText& text) {
  MOTIONDB_RETURN_IF_ERROR(connection.OfTexts(
      connection
          .Query(
              "INSERT INTO clip_text (rowid, title, description, tags, labels, subject, file_name) "
              "VALUES (?, ?, ?, ?, ?, ?, ?)",
              clip_key, text[0], text[1], text[2], text[3], text[4], text[5])
          .RunLater()));
  return connection.FlushTexts();
}

absl::Status UpdateClipText(Connection& connection, std::int64_t clip_key, const ClipText& text) {
  return connection.OfTexts(
      connection
          .Query(
              "UPDATE clip_text SET title = ?, description = ?, tags = ?, labels = ?, subject = ?, "
              "file_name = ? WHERE rowid = ?",
              text[0], text[1], text[2], text[3], text[4], text[5], clip_key)
          .Run());
}

absl::Status DeleteClipText(Connection& connection, std::int64_t clip_key) {
  MOTIONDB_RETURN_IF_ERROR(connection.OfTexts(
      connection.Query("DELETE FROM clip_text WHERE rowid = ?", clip_key).Run()));
  return connection.FlushTexts();
}

absl::Status FillClipText(Connection& connection) {
  // A row for each segment of a clip, and one for a clip without segments.
  Statement row = connection.Query(
      "SELECT clip.clip_key, title, description, subject, file_name, annotations, label "
      "FROM clip LEFT JOIN segment USING (clip_key) WHERE deleted = 0 ORDER BY clip.clip_key");
  MOTIONDB_ASSIGN_OR_RETURN(bool found, row.Step());
  while (found) {
    const std::int64_t key = row.Integer(0);
    ClipRecord record;
    record.title = row.Text(1);
    record.description = row.Text(2);
    record.subject = row.Text(3);
    record.file_name = row.Text(4);
    if (!row.IsNull(5)) DecodeAnnotations(row.Blob(5), record).IgnoreError();
    std::vector<SegmentRecord> segments;
    while (found && row.Integer(0) == key) {
      if (!row.IsNull(6)) segments.emplace_back().label = row.Text(6);
      MOTIONDB_ASSIGN_OR_RETURN(found, row.Step());
    }
    MOTIONDB_RETURN_IF_ERROR(InsertClipText(connection, key, TextOf(record, segments)));
  }
  return absl::OkStatus();
}

}  // namespace motiondb::storage
