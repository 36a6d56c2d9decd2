// Rows of the table `skeleton`. Functions keep no state; they run in the transaction of their
// caller.
#pragma once

#include <cstdint>
#include <string>
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

// Deletes those that no clip is on.
absl::Status DeleteUnusedSkeletons(Connection& connection, std::int64_t database_key);

}  // namespace motiondb::storage
