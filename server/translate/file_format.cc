#include "server/translate/file_format.h"

#include "core/format/plausibility.h"
#include "core/motion/error.h"
#include "server/translate/message_fields.h"

namespace motiondb::server {
namespace {

constexpr std::size_t kMaxTakeBytes = 255;

}  // namespace

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

absl::StatusOr<core::FileFormat> ParseWrittenFormat(std::string_view field, v1::FileFormat format) {
  MOTIONDB_ASSIGN_OR_RETURN(const core::FileFormat parsed, ParseFormat(field, format));
  if (core::InfoOf(parsed).is_written) return parsed;
  return FieldViolation(field, "{} files are read only; expected BVH, TRC, C3D, CSV, NPZ or GLTF",
                        core::InfoOf(parsed).name);
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

absl::Status CheckSkeletonFile(std::string_view prefix, core::FileFormat format,
                               const std::string& skeleton_file_name) {
  const std::string field = fmt::format("{}.skeleton_file_name", prefix);
  if (format == core::FileFormat::kAmc && skeleton_file_name.empty()) {
    return FieldViolation(field, "expected the ASF skeleton file of the AMC file");
  }
  if (core::InfoOf(format).skeleton.empty() && !skeleton_file_name.empty()) {
    return FieldViolation(field, "only AMC and CSV files have a skeleton file; omit '{}'",
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
  MOTIONDB_RETURN_IF_ERROR(CheckPlainText(field("take"), conventions.take(), kMaxTakeBytes));
  from.read.take = conventions.take();
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
