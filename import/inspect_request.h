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

// Returns a line with the result, or the error, of the request with this index, from 0.
std::string InspectionLine(int index, const std::string& file,
                           const absl::StatusOr<core::Inspection>& inspection);

}  // namespace motiondb::importer
