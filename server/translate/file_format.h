// Formats and conventions of motion files: requests <-> core. Safe to call from any thread.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "motiondb/v1/clip.pb.h"

namespace motiondb::server {

v1::FileFormat ToProto(core::FileFormat format);

// The format given, or else the one that the file's name tells. `prefix` leads the names of fields:
// "header" for header.format and header.file_name.
absl::StatusOr<core::FileFormat> FileFormatFrom(std::string_view prefix, v1::FileFormat format,
                                                const std::string& file_name);

// INVALID_ARGUMENT where an AMC comes without its ASF, or another format with one.
absl::Status CheckSkeletonFile(std::string_view prefix, core::FileFormat format,
                               const std::string& skeleton_file_name);

struct Conventions {
  core::ReadOptions read;
  std::optional<double> leg_length_m;
};

// Numbers must be finite and not negative; 0 means not given.
absl::StatusOr<Conventions> ConventionsFrom(std::string_view prefix,
                                            const v1::SourceConventions& conventions);

}  // namespace motiondb::server
