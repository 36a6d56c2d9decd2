// Requests and answers of `motiondb-import inspect`: one JSON object per line.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "core/inspection/inspection.h"

namespace motiondb::importer {

struct InspectRequest {
  std::string file;
  std::string skeleton;  // ASF of an AMC file; empty: none
  core::ReadOptions given;
  std::optional<double> leg_length_m;
};

// INVALID_ARGUMENT says what is wrong with the line.
absl::StatusOr<InspectRequest> ParseInspectRequest(std::string_view line);

// Returns the result, or the error, as a JSON object in one line.
std::string InspectionJson(const absl::StatusOr<core::Inspection>& inspection);

// Returns the answer to the request with this index, from 0: index, file and `result`, a JSON
// object from a child process. A result that is no JSON object in one line becomes an error: a
// child may be in the hands of its file.
std::string AnswerLine(int index, const std::string& file, const std::string& result);

}  // namespace motiondb::importer
