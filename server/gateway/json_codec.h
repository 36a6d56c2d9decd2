// Messages as JSON and as protobuf, by the mapping of proto3 (protobuf.dev/programming-guides/json)
// and the descriptors of the generated code.
#pragma once

#include <google/protobuf/descriptor.h>

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::server {

// Returns the serialized message. Field names may be those of the proto or in camelCase. Empty text
// is the empty message. INVALID_ARGUMENT with the place: no JSON, an unknown field, a wrong type,
// invalid UTF-8, nested too deeply.
absl::StatusOr<std::string> ProtoFromJson(const google::protobuf::Descriptor& type,
                                          std::string_view json);

// Returns JSON with names in camelCase and without default values. INTERNAL if `bytes` is no
// message of this type.
absl::StatusOr<std::string> JsonFromProto(const google::protobuf::Descriptor& type,
                                          const std::string& bytes);

// Returns INVALID_ARGUMENT if `bytes` is no message of this type, which must be generated code.
absl::Status CheckProto(const google::protobuf::Descriptor& type, const std::string& bytes);

}  // namespace motiondb::server
