// Relates the tree of a filter to fields and checks the types of its values.
#pragma once

#include "absl/status/statusor.h"
#include "server/filter/predicate.h"
#include "server/filter/syntax.h"

namespace motiondb::server {

// INVALID_ARGUMENT with the byte for an unknown field, a comparator that the field does not have,
// or a value of another type.
absl::StatusOr<Predicate> CompileFilter(const FilterSyntax& syntax, FieldScope scope);

}  // namespace motiondb::server
