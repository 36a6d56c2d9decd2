// The formats of motion files.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::core {

enum class FileFormat { kBvh, kAmc, kTrc, kC3d };

// Returns the format for a file's extension (any case). INVALID_ARGUMENT lists the known ones.
absl::StatusOr<FileFormat> FormatOfPath(std::string_view path);

}  // namespace motiondb::core
