// Edits of annotations and their history, table `edit`. The functions run in the caller's
// transaction.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/annotation_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// See AnnotationStore::Edit and UndoEdit.
absl::StatusOr<EditRecord> MakeEdit(Connection& connection, const std::string& database,
                                    std::span<const Change> changes, const std::string& author,
                                    std::int64_t time_us);
absl::StatusOr<EditRecord> UndoStoredEdit(Connection& connection, const std::string& database,
                                          std::int64_t edit, const std::string& author,
                                          std::int64_t time_us);

// See AnnotationStore::ListEdits.
absl::StatusOr<std::vector<EditRecord>> SelectEdits(Connection& connection,
                                                    const std::string& database,
                                                    const std::string& clip, std::int64_t before,
                                                    int limit);
// DATA_LOSS if the edit with this row id cannot be decoded.
absl::Status CheckEdit(Connection& connection, std::int64_t edit_key);

}  // namespace motiondb::storage
