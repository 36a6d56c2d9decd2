// The full-text index of clips: table `clip_text`, whose row ids are the keys of clips. The
// functions run in the caller's transaction, except RebuildClipText. The index is derived from the
// rows and can be made again, so errors that a corrupt index causes are marked: IsOfSearchIndex.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/cord.h"
#include "storage/annotation_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/clip_text.h"
#include "storage/text_query.h"

namespace motiondb::storage {

inline constexpr char kSearchIndexUrl[] = "motiondb.search_index";

// Converts the error of a statement that uses only the index into a marked DATA_LOSS if corruption
// can be its cause: FTS5 also reports contradictory rows as a violated constraint, and missing ones
// as a logic error. Returns other statuses unchanged.
inline absl::Status OfSearchIndex(const absl::Status& status) {
  if (!absl::IsDataLoss(status) && !absl::IsAlreadyExists(status) && !absl::IsInternal(status)) {
    return status;
  }
  absl::Status marked = absl::DataLossError(status.message());
  marked.SetPayload(kSearchIndexUrl, absl::Cord());
  return marked;
}

inline bool IsOfSearchIndex(const absl::Status& status) {
  return status.GetPayload(kSearchIndexUrl).has_value();
}

// Adds the SQL function `motiondb_words` (NormalizeText) to a connection. Returns an SQLite result
// code.
int AddWordsFunction(sqlite3* database);

// Replaces the index, whatever its state, by one that is filled from the clips. Pages of a corrupt
// index that SQLite cannot free stay unused. The time is proportional to the number of clips. Makes
// its own transactions. REQUIRES: `connection` is in no transaction.
absl::Status RebuildClipText(Connection& connection);

// See AnnotationStore::SearchClips.
absl::StatusOr<std::vector<TextMatch>> SelectTextMatches(Connection& connection,
                                                         const std::string& database,
                                                         const std::string& query);

// DATA_LOSS unless the index was made from this text of a clip. Reads only.
absl::Status CheckClipText(Connection& connection, std::int64_t clip_key, const ClipText& text);

// Compares the words of the whole index with the texts that it was made from. Returns the resource
// names of clips whose words differ; DATA_LOSS if it cannot be read. Writes only a temporary table.
absl::StatusOr<std::vector<std::string>> FindWrongWords(Connection& connection);

}  // namespace motiondb::storage
