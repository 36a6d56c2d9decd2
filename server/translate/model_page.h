// Page tokens of what belongs to one version of a model. A token of a model that has been replaced
// meanwhile is ABORTED: what was listed before and what follows would not fit together. Safe to
// call from any thread.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/translate/resource_name.h"
#include "storage/records.h"

namespace motiondb::server {

struct ModelPosition {
  int version = 0;  // 0: the list begins
  int index = 0;
};

std::string EncodeModelPosition(std::string_view scope, const ModelPosition& position);

// INVALID_ARGUMENT if the token was not given out for this list.
absl::StatusOr<ModelPosition> DecodeModelPosition(std::string_view scope, const std::string& token);

// The model to look for: on a later page the current one, whatever its version, so that a model
// that was replaced is found out by CheckStillCurrent.
ModelId PinnedTo(const ModelPosition& position, const ModelId& id);

// ABORTED if the position is of another model than `current`.
absl::Status CheckStillCurrent(const ModelPosition& position, const storage::ModelRecord& current);

}  // namespace motiondb::server
