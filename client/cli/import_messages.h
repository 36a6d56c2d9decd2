// Messages of motiondb-import: requests for files and options, and what it found in a file, as
// text.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/motion_file.h"

namespace motiondb::client {

// INVALID_ARGUMENT if a name is not UTF-8 text; NOT_FOUND without the skeleton of an AMC file.
absl::StatusOr<nlohmann::json> ImportRequest(const std::filesystem::path& file,
                                             const SourceOptions& source);

// The request as a line with its end.
std::string LineOf(const nlohmann::json& request);

// Returns whether ingest would accept the file.
bool IsAccepted(const nlohmann::json& inspection);

// Returns why the file would be rejected; empty if it would be accepted.
std::string RejectionText(const nlohmann::json& inspection);

// Returns the report of a file: its joints or markers with their roles, conventions, measures,
// notes and problems.
std::string InspectionText(const nlohmann::json& inspection);

// Returns the report of an accepted file in one line.
std::string InspectionLine(const nlohmann::json& inspection);

}  // namespace motiondb::client
