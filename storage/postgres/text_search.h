// The search of the texts of clips in PostgreSQL. Its index, a tsvector of the words of a clip,
// finds candidates; text_query.h decides, so that a query finds the same clips in every store.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/text_query.h"

namespace motiondb::storage {

// See AnnotationStore::SearchClips. Runs in the caller's transaction.
absl::StatusOr<std::vector<TextMatch>> SearchPostgresTexts(Connection& connection,
                                                           const std::string& database,
                                                           const std::string& query);

// Returns a text of the type tsquery: the clips that have all words of the terms, in any place.
std::string ToTsQuery(const std::vector<TextTerm>& terms);

}  // namespace motiondb::storage
