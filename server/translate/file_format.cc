#include "server/translate/file_format.h"

#include "core/format/plausibility.h"
#include "core/motion/error.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {

v1::FileFormat ToProto(core::FileFormat format) {
  switch (format) {
    case core::FileFormat::kBvh:
      return v1::FILE_FORMAT_BVH;
    case core::FileFormat::kAmc:
      return v1::FILE_FORMAT_AMC;
    case core::FileFormat::kTrc:
      return v1::FILE_FORMAT_TRC;
    case core::FileFormat::kC3d:
      return v1::FILE_FORMAT_C3D;
  }
  return v1::FILE_FORMAT_UNSPECIFIED;
}

absl::StatusOr<core::FileFormat> ParseFileFormat(std::string_view prefix, v1::FileFormat format,
                                                 const std::string& file_name) {
  switch (format) {
    case v1::FILE_FORMAT_BVH:
      return core::FileFormat::kBvh;
    case v1::FILE_FORMAT_AMC:
      return core::FileFormat::kAmc;
    case v1::FILE_FORMAT_TRC:
      return core::FileFormat::kTrc;
    case v1::FILE_FORMAT_C3D:
      return core::FileFormat::kC3d;
    case v1::FILE_FORMAT_UNSPECIFIED:
      break;
    default:
      return FieldViolation(fmt::format("{}.format", prefix),
                            "unknown format {}; expected BVH, AMC, TRC or C3D",
                            static_cast<int>(format));
  }
  auto by_extension = core::FormatOfPath(file_name);
  if (by_extension.ok()) return by_extension;
  return AtField(fmt::format("{}.file_name", prefix), by_extension.status());
}

absl::Status CheckSkeletonFile(std::string_view prefix, core::FileFormat format,
                               const std::string& skeleton_file_name) {
  const std::string field = fmt::format("{}.skeleton_file_name", prefix);
  if (format == core::FileFormat::kAmc && skeleton_file_name.empty()) {
    return FieldViolation(field, "expected the ASF skeleton file of the AMC file");
  }
  if (format != core::FileFormat::kAmc && !skeleton_file_name.empty()) {
    return FieldViolation(field, "only an AMC file has a skeleton file; omit '{}'",
                          skeleton_file_name);
  }
  return absl::OkStatus();
}

absl::StatusOr<Conventions> ParseConventions(std::string_view prefix,
                                             const v1::SourceConventions& conventions) {
  const auto field = [&](std::string_view name) {
    return fmt::format("{}.conventions.{}", prefix, name);
  };
  Conventions from;
  if (conventions.has_metres_per_unit()) {
    from.read.metres_per_unit = conventions.metres_per_unit();
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("metres_per_unit"), *from.read.metres_per_unit));
  }
  if (conventions.has_frame_rate_hz()) {
    from.read.frame_rate_hz = conventions.frame_rate_hz();
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("frame_rate_hz"), *from.read.frame_rate_hz));
  }
  if (conventions.has_leg_length_m()) {
    from.leg_length_m = conventions.leg_length_m();
    MOTIONDB_RETURN_IF_ERROR(CheckPositive(field("leg_length_m"), *from.leg_length_m));
    if (!conventions.force()) {
      MOTIONDB_RETURN_IF_ERROR(
          AtField(field("leg_length_m"), core::CheckGivenLegLength(*from.leg_length_m)));
    }
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
      return FieldViolation(field("up_axis"), "unknown axis {}; expected X, Y or Z",
                            static_cast<int>(conventions.up_axis()));
  }
  from.force = conventions.force();
  return from;
}

}  // namespace motiondb::server
