// An observation of a request -> states as the models of a database know them. Safe to call from
// any thread.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "core/motion/states.h"
#include "server/engine/engine.h"
#include "server/engine/representation.h"

namespace motiondb::v1 {
class Observation;
}

namespace motiondb::server {

// Not scaled; NaN where a marker was missing. `field` is the observation's own name in the request,
// and leads the names of fields in errors. Codes: INVALID_ARGUMENT, NOT_FOUND (a skeleton),
// CANCELLED; and IsHeavyWork.
absl::StatusOr<core::StateSequence> StatesFrom(std::string_view field,
                                               const v1::Observation& observation, Engine& engine,
                                               const LiveDatabase& database,
                                               const WorkTerms& terms);

// The database's markers, at the observation's own frame rate.
absl::StatusOr<core::MarkerMotion> MarkersFrom(std::string_view field,
                                               const v1::Observation& observation, Engine& engine,
                                               const LiveDatabase& database,
                                               const WorkTerms& terms);

}  // namespace motiondb::server
