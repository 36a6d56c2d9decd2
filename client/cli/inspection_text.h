// Results of motiondb-import as text: the report of one file, and lines of many.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace motiondb::client {

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
