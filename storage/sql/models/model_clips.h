// The table model_clip: which stored clips a model was built from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/model/model.h"
#include "storage/sql/connection/connection.h"

namespace motiondb::storage {

// Whether FindModelClips also accepts deleted clips.
enum class DeletedClips { kNot, kToo };
// Returns the keys of the model's clips with indices `first` to `end` - 1. NOT_FOUND also if a
// stored clip has the same id but other states.
absl::StatusOr<std::vector<std::int64_t>> FindModelClips(Connection& connection,
                                                         std::int64_t database_key,
                                                         const core::Model& model,
                                                         std::ptrdiff_t first, std::ptrdiff_t end,
                                                         DeletedClips deleted);

// Inserts the clips with these keys; the first one has the index `first` in the model.
absl::Status InsertModelClips(Connection& connection, std::int64_t model_key, std::int64_t first,
                              const std::vector<std::int64_t>& clip_keys);

}  // namespace motiondb::storage
