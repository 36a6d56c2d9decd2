// Storing models. A built model is stored in many short transactions, so that other writes do not
// wait long. It is staged, and therefore invisible, until the last transaction publishes it.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sql/connection/connection.h"
#include "storage/sql/tables/deleted_databases.h"

namespace motiondb::storage {

// See MotionStore::PutModel. Only one call at a time for a database, in a process. Each transaction
// checks the fence: a builder whose lease another process has taken over neither publishes a model
// nor frees the other's. If a call fails or the process ends, the next call for the database frees
// the staged model.
absl::StatusOr<ModelRecord> PutModelInPieces(const TransactionRunner& write,
                                             const std::string& database, const core::Model& model,
                                             std::int64_t create_time_us, const ModelTerms& terms);

// Frees the data of staged and former models that the current model does not use. DATA_LOSS if some
// data cannot be read and stays. ABORTED if `fence` is outdated; see ModelTerms.
absl::Status FreeUnneededModels(const TransactionRunner& write, const std::string& database,
                                std::int64_t fence);

// See MotionStore::PutExtension. Runs in the caller's transaction.
absl::StatusOr<ModelRecord> InsertExtension(Connection& connection, const std::string& database,
                                            const core::Model& model, double drift_fraction,
                                            std::int64_t create_time_us, const ModelTerms& terms);

// Marks the current model, if there is one, as former; FreeUnneededModels frees its data.
absl::Status RetireCurrentModel(Connection& connection, const std::string& database,
                                const ModelTerms& terms);

}  // namespace motiondb::storage
