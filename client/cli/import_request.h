// Requests of motiondb-import for files and options of the command line.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/motion_file.h"

namespace motiondb::client {

// INVALID_ARGUMENT if a name is not UTF-8 text; NOT_FOUND without the skeleton of an AMC file.
absl::StatusOr<nlohmann::json> ImportRequest(const std::filesystem::path& file,
                                             const SourceOptions& source);

// The request as a line with its end.
std::string LineOf(const nlohmann::json& request);

}  // namespace motiondb::client
