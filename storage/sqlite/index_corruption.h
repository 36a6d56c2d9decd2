// Marks errors of the search index, which is derived from the rows and can be made again.
#pragma once

#include "absl/status/status.h"
#include "absl/strings/cord.h"

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

}  // namespace motiondb::storage
