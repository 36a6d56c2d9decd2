// The HTTP API as OpenAPI 3.1, generated at build time (openapi.h).
#pragma once

#include <string_view>

namespace motiondb::server {

extern const std::string_view kOpenApiJson;

}  // namespace motiondb::server
