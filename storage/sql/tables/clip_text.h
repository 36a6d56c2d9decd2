// The searched texts of clips: table `clip_text`, whose row ids are the keys of clips. Each engine
// searches it in its own way. The functions run in the caller's transaction.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "storage/sql/connection/connection.h"
#include "storage/text_query.h"

namespace motiondb::storage {

// REQUIRES: the clip has no text in the index.
absl::Status InsertClipText(Connection& connection, std::int64_t clip_key, const ClipText& text);
// Connection::FlushTexts must follow, before another table changes.
absl::Status UpdateClipText(Connection& connection, std::int64_t clip_key, const ClipText& text);
// OK if the clip has none.
absl::Status DeleteClipText(Connection& connection, std::int64_t clip_key);
// Fills the empty index with the texts of all clips. A clip whose tags are corrupt is found by the
// rest of its text.
absl::Status FillClipText(Connection& connection);

}  // namespace motiondb::storage
