#include "storage/sql/clip_text.h"

#include "core/motion/error.h"

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

}  // namespace motiondb::storage
