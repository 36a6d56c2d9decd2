// What a query is asked of.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/engine/engine.h"

namespace motiondb::server {

// The model that is current when a query begins, kept to its end.
struct QuerySubject {
  std::shared_ptr<LiveDatabase> database;
  std::shared_ptr<const Snapshot> snapshot;
};

// `name` is that of a database, `databases/{database}`, as the request has it in `field`.
// INVALID_ARGUMENT, NOT_FOUND; FAILED_PRECONDITION where there is no model.
absl::StatusOr<QuerySubject> FindSubject(Engine& engine, std::string_view field,
                                         const std::string& name);

}  // namespace motiondb::server
