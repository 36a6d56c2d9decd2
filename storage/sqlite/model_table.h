// Rows of the table `model` and what belongs to models. Functions keep no state; they run in the
// transaction of their caller. Where a database is named, NOT_FOUND says that it is not there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/chunk_table.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

inline BlobOwner ModelOwner(std::int64_t model_key) { return {"model", model_key}; }

// The current model as it is stored.
struct CurrentModel {
  std::int64_t model_key = 0;
  std::int64_t built_key = 0;  // of the build that it is or extends
  int version = 0;
  int clip_count = 0;
  int frame_count = 0;
};

// NOT_FOUND if there is none.
absl::StatusOr<CurrentModel> FindCurrentModel(Connection& connection, const std::string& database,
                                              std::int64_t database_key);

// `connections` are one or more, each in a transaction; the first one decides what is current, the
// others help to read where they see the same.
absl::StatusOr<core::Model> SelectCurrentModel(std::span<Connection* const> connections,
                                               const std::string& database,
                                               const core::ParallelFor& parallel);
// As MotionStore::FindModelStaleness.
absl::StatusOr<ModelStaleness> SelectModelStaleness(Connection& connection,
                                                    const std::string& database);
absl::StatusOr<ModelRecord> SelectModel(Connection& connection, const std::string& database,
                                        int version);
absl::StatusOr<std::vector<ModelRecord>> SelectModels(Connection& connection,
                                                      const std::string& database, int before,
                                                      int limit);

}  // namespace motiondb::storage
