// Converts formats and conventions of motion files between requests and core.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/format/motion_file.h"
#include "motiondb/v1/clip.pb.h"

namespace motiondb::server {

v1::FileFormat ToProto(core::FileFormat format);

// Returns the format of a request. INVALID_ARGUMENT, with the field, lists the known ones.
absl::StatusOr<core::FileFormat> ParseFormat(std::string_view field, v1::FileFormat format);

// Returns `format`; if unspecified, the format of the extension of `file_name`. `prefix` is the
// path of the message for errors: "header" for header.format and header.file_name.
absl::StatusOr<core::FileFormat> ParseFileFormat(std::string_view prefix, v1::FileFormat format,
                                                 const std::string& file_name);

struct Conventions {
  core::ReadOptions read;
  std::optional<double> leg_length_m;
  bool force = false;  // accept an implausible body
};

// Converts conventions. INVALID_ARGUMENT for an unknown axis.
absl::StatusOr<Conventions> ParseConventions(std::string_view prefix,
                                             const v1::SourceConventions& conventions);

}  // namespace motiondb::server
