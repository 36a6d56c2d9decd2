// Rows of the table `skeleton`, and ids that are not taken. Functions keep no state; they run in
// the transaction of their caller.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// The key of a skeleton that is alike in every number and name, stored now if there was none. A new
// one is called as the skeleton calls itself, made fit for an id.
absl::StatusOr<std::int64_t> FindOrInsertSkeleton(Connection& connection, std::int64_t database_key,
                                                  const core::Skeleton& skeleton);
absl::StatusOr<core::Skeleton> SelectSkeleton(Connection& connection, const std::string& database,
                                              const std::string& id);
absl::StatusOr<std::vector<SkeletonRecord>> SelectSkeletons(Connection& connection,
                                                            const std::string& database,
                                                            const Page& page);

// Deletes one that no clip is on.
absl::Status DeleteUnusedSkeleton(Connection& connection, std::int64_t skeleton_key);

// `wanted`, or one of "wanted-2", "wanted-3", ... for which `taken_sql`, a query with the
// parameters database_key and id, gives no row: the first, where those before it have no gap.
absl::StatusOr<std::string> FreeId(Connection& connection, std::string_view taken_sql,
                                   std::int64_t database_key, const std::string& wanted);

}  // namespace motiondb::storage
