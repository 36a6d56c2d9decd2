// Storing models. A built one is stored in pieces, each in a short transaction, so that other
// changes need not wait for all of it: staged, which nobody sees, then published by the last piece.
// Functions keep no state.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "storage/motion_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/deleted_databases.h"

namespace motiondb::storage {

// As MotionStore::PutModel. What an error or the end of the process leaves staged is freed by the
// next call for the database. One at a time for a database.
absl::StatusOr<ModelRecord> PutModelInPieces(const WriteOnce& write, const std::string& database,
                                             const core::Model& model, std::int64_t create_time_us);

// Frees what staged and superseded models hold, but for what the current one needs. DATA_LOSS:
// what cannot be read stays.
absl::Status FreeUnneededModels(const WriteOnce& write, const std::string& database);

// As MotionStore::PutExtension, in the transaction of the caller.
absl::StatusOr<ModelRecord> InsertExtension(Connection& connection, const std::string& database,
                                            const core::Model& model, double drift_fraction,
                                            std::int64_t create_time_us);

// Makes the current model, if there is one, a superseded one; FreeUnneededModels frees it.
absl::Status RetireCurrentModel(Connection& connection, const std::string& database);

}  // namespace motiondb::storage
