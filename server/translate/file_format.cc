#include "server/translate/file_format.h"

#include "core/motion/error.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {

// The values of both enumerations have the same order.
static_assert(v1::FILE_FORMAT_BVH == static_cast<int>(core::FileFormat::kBvh) + 1);
static_assert(v1::FILE_FORMAT_COLLADA == static_cast<int>(core::FileFormat::kCollada) + 1);

v1::FileFormat ToProto(core::FileFormat format) {
  return static_cast<v1::FileFormat>(static_cast<int>(format) + 1);
}

absl::StatusOr<core::FileFormat> ParseFormat(std::string_view field, v1::FileFormat format) {
  if (format > v1::FILE_FORMAT_UNSPECIFIED && format <= v1::FILE_FORMAT_COLLADA) {
    return static_cast<core::FileFormat>(static_cast<int>(format) - 1);
  }
  std::string names;
  for (const core::FormatInfo& info : core::KnownFormats()) {
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  return FieldViolation(field, "unknown format {}; expected one of {}", static_cast<int>(format),
                        names);
}

absl::StatusOr<core::FileFormat> ParseFileFormat(std::string_view prefix, v1::FileFormat format,
                                                 const std::string& file_name) {
  if (format != v1::FILE_FORMAT_UNSPECIFIED) {
    return ParseFormat(fmt::format("{}.format", prefix), format);
  }
  auto by_extension = core::FormatOfPath(file_name);
  if (by_extension.ok()) return by_extension;
  return AtField(fmt::format("{}.file_name", prefix), by_extension.status());
}

absl::StatusOr<Conventions> ParseConventions(std::string_view prefix,
                                             const v1::SourceConventions& conventions) {
  Conventions from;
  if (conventions.has_metres_per_unit()) {
    from.read.metres_per_unit = conventions.metres_per_unit();
  }
  if (conventions.has_frame_rate_hz()) {
    from.read.frame_rate_hz = conventions.frame_rate_hz();
  }
  from.read.take = conventions.take();
  if (conventions.has_leg_length_m()) {
    from.leg_length_m = conventions.leg_length_m();
  }
  switch (conventions.up_axis()) {
    case v1::UP_AXIS_UNSPECIFIED:
      break;
    case v1::UP_AXIS_X:
      from.read.up_axis = core::UpAxis::kX;
      break;
    case v1::UP_AXIS_Y:
      from.read.up_axis = core::UpAxis::kY;
      break;
    case v1::UP_AXIS_Z:
      from.read.up_axis = core::UpAxis::kZ;
      break;
    default:
      return FieldViolation(fmt::format("{}.conventions.up_axis", prefix),
                            "unknown axis {}; expected X, Y or Z",
                            static_cast<int>(conventions.up_axis()));
  }
  from.force = conventions.force();
  return from;
}

}  // namespace motiondb::server
