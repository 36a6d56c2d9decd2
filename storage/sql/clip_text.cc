#include "storage/sql/clip_text.h"

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
          .Run()));
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
  Statement clip = connection.Query(
      "SELECT clip_key, title, description, subject, file_name, annotations FROM clip "
      "WHERE deleted = 0");
  while (true) {
    MOTIONDB_ASSIGN_OR_RETURN(const bool found, clip.Step());
    if (!found) return absl::OkStatus();
    ClipRecord record;
    record.title = clip.Text(1);
    record.description = clip.Text(2);
    record.subject = clip.Text(3);
    record.file_name = clip.Text(4);
    if (!clip.IsNull(5)) DecodeAnnotations(clip.Blob(5), record).IgnoreError();
    std::vector<SegmentRecord> segments;
    Statement label =
        connection.Query("SELECT DISTINCT label FROM segment WHERE clip_key = ?", clip.Integer(0));
    while (true) {
      MOTIONDB_ASSIGN_OR_RETURN(const bool has_label, label.Step());
      if (!has_label) break;
      segments.emplace_back().label = label.Text(0);
    }
    MOTIONDB_RETURN_IF_ERROR(InsertClipText(connection, clip.Integer(0), TextOf(record, segments)));
  }
}

}  // namespace motiondb::storage
