// Rows of the table `model` and what belongs to models. Functions keep no state; they run in the
// transaction of their caller. Where a database is named, NOT_FOUND says that it is not there.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/clip_table.h"
#include "storage/sqlite/connection.h"

namespace motiondb::storage {

// As MotionStore::PutModel, which also says what NOT_FOUND means.
absl::StatusOr<ModelRecord> InsertModel(Connection& connection, const std::string& database,
                                        const core::Model& model, std::int64_t create_time_us,
                                        Remains remains);
// As MotionStore::PutExtension.
absl::StatusOr<ModelRecord> InsertExtension(Connection& connection, const std::string& database,
                                            const core::Model& model, double stale_share,
                                            std::int64_t create_time_us);
// `connections` are one or more, each in a transaction; the first one decides what is current, the
// others help to read where they see the same.
absl::StatusOr<core::Model> SelectCurrentModel(std::span<Connection* const> connections,
                                               const std::string& database,
                                               const core::ParallelFor& parallel);
// As MotionStore::FindModelGap.
absl::StatusOr<ModelGap> SelectModelGap(Connection& connection, const std::string& database);
absl::StatusOr<ModelRecord> SelectModel(Connection& connection, const std::string& database,
                                        int version);
absl::StatusOr<std::vector<ModelRecord>> SelectModels(Connection& connection,
                                                      const std::string& database, int before,
                                                      int limit);

// Makes the current model, if there is one, a superseded one, and deletes all that only it needed.
absl::Status RetireCurrentModel(Connection& connection, const std::string& database,
                                Remains remains);

}  // namespace motiondb::storage
