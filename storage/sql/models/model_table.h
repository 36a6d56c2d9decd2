// Rows of the tables of models. The functions run in the caller's transaction. NOT_FOUND if a named
// database does not exist.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/records.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/chunk_table.h"
#include "storage/sql/tables/deleted_databases.h"

namespace motiondb::storage {

inline BlobOwner ModelOwner(std::int64_t model_key) { return {"model", model_key}; }

// The row of the current model.
struct CurrentModel {
  std::int64_t model_key = 0;
  std::int64_t built_key = 0;  // the build that it is or extends
  int version = 0;
  int clip_count = 0;
  int frame_count = 0;
};

// NOT_FOUND if there is none.
absl::StatusOr<CurrentModel> FindCurrentModel(Connection& connection, const std::string& database,
                                              std::int64_t database_key);

// Reads the current model. `connections`: one or more, each in a transaction. The first determines
// the current model; the others help to read if they see the same model.
absl::StatusOr<core::Model> SelectCurrentModel(std::span<Connection* const> connections,
                                               const std::string& database,
                                               const core::ParallelFor& parallel);
// See MotionStore::ReadExtension.
absl::StatusOr<core::Model> SelectExtension(Connection& connection, const std::string& database,
                                            std::int32_t base_version, const core::Model& base,
                                            const core::ParallelFor& parallel);
// See MotionStore::FindModelStaleness.
absl::StatusOr<ModelStaleness> SelectModelStaleness(Connection& connection,
                                                    const std::string& database);
absl::StatusOr<ModelRecord> SelectModel(Connection& connection, const std::string& database,
                                        int version);
absl::StatusOr<std::vector<ModelRecord>> SelectModels(Connection& connection,
                                                      const std::string& database, int before,
                                                      int limit);

// ABORTED if a condition of the terms is not met. `database_key`: found by FindDatabase in this
// transaction.
absl::Status CheckModelTerms(Connection& connection, const std::string& database,
                             std::int64_t database_key, const ModelTerms& terms);

// Runs pieces as `write`, each only if `fence` is not outdated (ModelTerms::fence). The arguments
// must outlive the result.
TransactionRunner Fenced(const TransactionRunner& write, const std::string& database,
                         std::int64_t fence);

}  // namespace motiondb::storage
