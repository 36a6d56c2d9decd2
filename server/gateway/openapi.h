// The HTTP API as OpenAPI 3.1.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace google::protobuf {
class FileDescriptorSet;
}  // namespace google::protobuf

namespace motiondb::server {

// Makes the document from descriptors with their comments, at build time. Returns it as JSON: a
// path for each RPC that does not stream requests, and schemas of all messages by the JSON mapping
// of proto3. `files`: with imports and source info. INVALID_ARGUMENT if they do not form a pool, or
// use a type of google.protobuf without a known mapping.
absl::StatusOr<std::string> OpenApiDocument(const google::protobuf::FileDescriptorSet& files,
                                            const std::string& version);

// The document, in a source file that openapi_main.cc generates.
extern const std::string_view kOpenApiJson;

}  // namespace motiondb::server
