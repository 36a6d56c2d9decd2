// Rows of the table `skeleton`, and the choice of free ids. The functions run in the caller's
// transaction.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Returns the key of an identical stored skeleton; stores the skeleton if there is none. The id of
// a new one is the skeleton's name with invalid characters replaced.
absl::StatusOr<std::int64_t> FindOrInsertSkeleton(Connection& connection, std::int64_t database_key,
                                                  const core::Skeleton& skeleton);
absl::StatusOr<core::Skeleton> SelectSkeleton(Connection& connection, const std::string& database,
                                              const std::string& id);
absl::StatusOr<std::vector<SkeletonRecord>> SelectSkeletons(Connection& connection,
                                                            const std::string& database,
                                                            const Page& page);

// Deletes a skeleton if no clip uses it.
absl::Status DeleteUnusedSkeleton(Connection& connection, std::int64_t skeleton_key);

// Returns a free id: `wanted`, "wanted-2", "wanted-3", ... An id is taken if `taken_sql`, a query
// with the parameters database_key and id, returns a row. Returns the first free id if the taken
// numbers have no gap, else any free id.
absl::StatusOr<std::string> ChooseFreeId(Connection& connection, std::string_view taken_sql,
                                         std::int64_t database_key, const std::string& wanted);

}  // namespace motiondb::storage
