// Converts the values of annotations to those of the store. Errors: INVALID_ARGUMENT with `field`,
// the path in the request, for a value that is none.
#pragma once

#include <google/protobuf/map.h>

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/records.h"

namespace motiondb::v1 {
class FieldValue;
}

namespace motiondb::server {

using GivenFields = google::protobuf::Map<std::string, v1::FieldValue>;

absl::StatusOr<storage::FieldValue> ParseFieldValue(std::string_view field,
                                                    const v1::FieldValue& value);
absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given);

}  // namespace motiondb::server
