// Answers of motiondb-import as JSON: one object per inspected file, and the table of formats.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "core/inspection/inspection.h"

namespace motiondb::importer {

// Returns the result, or the error, as a JSON object in one line.
std::string InspectionJson(const absl::StatusOr<core::Inspection>& inspection);

// Returns a JSON array of all formats: name, extensions, description, skeleton (extension of its
// skeleton file), has_takes, is_written.
std::string FormatsJson();

// Returns the answer to the request with this index, from 0: index, file and `result`, a JSON
// object from a child process. A result that is no JSON object in one line becomes an error: a
// child may be in the hands of its file.
std::string AnswerLine(int index, const std::string& file, const std::string& result);

}  // namespace motiondb::importer
