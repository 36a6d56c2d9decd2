// Revisions and tombstones of a database, and its changes. The functions run in the caller's
// transaction.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/clip_row.h"

namespace motiondb::storage {

absl::StatusOr<std::int64_t> SelectRevision(Connection& connection, const std::string& database);
// Gives the database the next revision and returns it.
absl::StatusOr<std::int64_t> NextRevision(Connection& connection, std::int64_t database_key);

// Notes that a segment was deleted, or created again. The tombstone of a segment replaces its
// former one; the oldest ones above the limit are removed.
absl::Status BurySegment(Connection& connection, const ClipRef& clip, const std::string& segment,
                         std::int64_t revision);
absl::Status UnburySegment(Connection& connection, const ClipRef& clip, const std::string& segment);
// Notes that a clip was deleted. Replaces the tombstones of its segments.
absl::Status BuryClip(Connection& connection, const ClipRef& clip, std::int64_t revision);

// See AnnotationStore::Changes.
absl::StatusOr<std::vector<ChangeRecord>> SelectChanges(Connection& connection,
                                                        const std::string& database,
                                                        std::int64_t after, int limit,
                                                        std::int64_t begun);

}  // namespace motiondb::storage
