// The model that a request names, and its clips.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/engine/snapshot.h"
#include "server/rpc/call.h"

namespace motiondb::server {

// Returns the current model, by name or version. Older models cannot be read: NOT_FOUND, or
// FAILED_PRECONDITION with reason MODEL_SUPERSEDED. FAILED_PRECONDITION if there is no model.
absl::StatusOr<SnapshotPointer> FindReadable(const Call& call, const ModelId& id);

// Returns the index of the clip of a request in the model; -1, the global graph, if `name` is
// empty. INVALID_ARGUMENT naming the field `clip`; NOT_FOUND with reason CLIP_NOT_FOUND.
absl::StatusOr<int> ClipIndex(const std::string& name, const ModelId& id, const Snapshot& snapshot);

}  // namespace motiondb::server
