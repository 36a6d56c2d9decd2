// Checks of the annotations of a clip, and their conversion to values of the store. Errors:
// INVALID_ARGUMENT with `field`, the path in the request, and the expected value.
#pragma once

#include <google/protobuf/map.h>
#include <google/protobuf/repeated_field.h>

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "storage/records.h"

namespace motiondb::v1 {
class FieldValue;
}

namespace motiondb::server {

using GivenTags = google::protobuf::RepeatedPtrField<std::string>;
using GivenFields = google::protobuf::Map<std::string, v1::FieldValue>;

absl::Status CheckTitle(std::string_view field, const std::string& title);
absl::Status CheckDescription(std::string_view field, const std::string& text);
absl::Status CheckFieldName(std::string_view field, std::string_view name);
absl::StatusOr<storage::FieldValue> ParseFieldValue(std::string_view field,
                                                    const v1::FieldValue& value);
// Ascending and distinct.
absl::StatusOr<std::vector<std::string>> ParseTags(std::string_view field, const GivenTags& given);
absl::StatusOr<storage::Fields> ParseFields(std::string_view field, const GivenFields& given);

}  // namespace motiondb::server
