// The formats of motion files.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"

namespace motiondb::core {

enum class FileFormat { kBvh, kAmc, kTrc, kC3d };

// The format that a file's extension names (any case). INVALID_ARGUMENT lists those known.
absl::StatusOr<FileFormat> FormatOfPath(std::string_view path);

}  // namespace motiondb::core
