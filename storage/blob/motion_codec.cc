#include "storage/blob/motion_codec.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <variant>

#include "core/format/conventions.h"
#include "core/motion/error.h"
#include "storage/blob/clip_codec.h"

namespace motiondb::storage {
namespace {

constexpr std::uint32_t kMotionVersion = 1;
constexpr std::uint8_t kJoints = 0;
constexpr std::uint8_t kMarkers = 1;
constexpr std::size_t kMaxNotes = 256;
constexpr std::size_t kMaxTextBytes = 16384;
constexpr std::size_t kMaxMarkers = 65'535;  // of a C3D, TRC or CSV file

void PutReport(FieldWriter& writer, const core::SourceReport& report) {
  writer.Put(report.metres_per_unit);
  writer.Put(static_cast<std::uint8_t>(report.unit_provenance));
  writer.Put(static_cast<std::uint8_t>(report.up_axis));
  writer.Put(static_cast<std::uint8_t>(report.up_provenance));
  writer.PutCount(report.notes.size());
  for (const std::string& note : report.notes) writer.PutText(note);
}

// Reads an enumeration with values from 0 to `last`.
template <typename Enum>
Enum GetEnum(FieldReader& reader, Enum last) {
  const auto value = reader.Get<std::uint8_t>();
  if (value > static_cast<std::uint8_t>(last)) {
    reader.Fail(core::DataLoss("motion: unknown value {} of an enumeration", value));
    return last;
  }
  return static_cast<Enum>(value);
}

std::string GetShortText(FieldReader& reader) {
  std::string text = reader.GetText();
  if (text.size() > kMaxTextBytes) {
    reader.Fail(core::DataLoss("motion: a text of {} bytes", text.size()));
  }
  return text;
}

core::SourceReport GetReport(FieldReader& reader) {
  core::SourceReport report;
  report.metres_per_unit = reader.Get<double>();
  if (reader.ok() && !(std::isfinite(report.metres_per_unit) && report.metres_per_unit > 0)) {
    reader.Fail(core::DataLoss("motion: invalid unit"));
  }
  report.unit_provenance = GetEnum(reader, core::Provenance::kAssumed);
  report.up_axis = GetEnum(reader, core::UpAxis::kMinusZ);
  report.up_provenance = GetEnum(reader, core::Provenance::kAssumed);
  const std::size_t note_count = reader.GetCount(sizeof(std::uint32_t));
  if (note_count > kMaxNotes) {
    reader.Fail(core::DataLoss("motion: {} notes", note_count));
    return report;
  }
  report.notes.resize(note_count);
  for (std::string& note : report.notes) note = GetShortText(reader);
  return report;
}

// Numbers in rows of `columns`: the number of rows, then the numbers.
template <typename Matrix>
void PutRows(FieldWriter& writer, const Matrix& matrix) {
  writer.PutCount(static_cast<std::size_t>(matrix.rows()));
  PutMatrix(writer, matrix);
}

template <typename Matrix>
void GetRows(FieldReader& reader, Eigen::Index columns, Matrix& matrix) {
  using Number = typename Matrix::Scalar;
  const std::size_t rows =
      reader.GetCount(std::max<std::size_t>(1, static_cast<std::size_t>(columns) * sizeof(Number)));
  if (reader.ok() && rows == 0) reader.Fail(core::DataLoss("motion: no frame"));
  if (!reader.ok()) return;
  matrix.resize(static_cast<Eigen::Index>(rows), columns);
  reader.GetElements(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

core::JointMotion GetJointMotion(FieldReader& reader) {
  core::JointMotion motion;
  motion.frame_rate_hz = reader.Get<double>();
  const std::string encoded = reader.GetText();
  if (!reader.ok()) return motion;
  SpanSource bytes(std::as_bytes(std::span(encoded)));
  auto skeleton = DecodeSkeleton(bytes);
  if (!skeleton.ok()) {
    reader.Fail(skeleton.status());
    return motion;
  }
  if (skeleton->joint_count() > core::kMaxFileJoints) {
    reader.Fail(core::DataLoss("motion: {} joints", skeleton->joint_count()));
    return motion;
  }
  motion.skeleton = std::make_shared<const core::Skeleton>(*std::move(skeleton));
  GetRows(reader, motion.skeleton->dof_count(), motion.angles);
  if (reader.ok() && !motion.angles.allFinite()) {
    reader.Fail(core::DataLoss("motion: a joint angle is not finite"));
  }
  return motion;
}

bool IsWholeOrMissing(const core::FrameMatrix& positions) {
  for (Eigen::Index frame = 0; frame < positions.rows(); ++frame) {
    for (Eigen::Index column = 0; column + 2 < positions.cols(); column += 3) {
      const auto point = positions.row(frame).segment<3>(column).array();
      if (!point.isFinite().all() && !point.isNaN().all()) return false;
    }
  }
  return true;
}

core::MarkerMotion GetMarkerMotion(FieldReader& reader) {
  core::MarkerMotion motion;
  motion.frame_rate_hz = reader.Get<double>();
  motion.first_frame = reader.Get<std::int32_t>();
  const std::size_t name_count = reader.GetCount(sizeof(std::uint32_t));
  if (name_count > kMaxMarkers) {
    reader.Fail(core::DataLoss("motion: {} markers", name_count));
    return motion;
  }
  motion.names.resize(name_count);
  for (std::string& name : motion.names) name = GetShortText(reader);
  const std::set<std::string> unique(motion.names.begin(), motion.names.end());
  if (reader.ok() && (motion.names.empty() || unique.size() != motion.names.size())) {
    reader.Fail(core::DataLoss("motion: no marker, or two with one name"));
  }
  GetRows(reader, 3 * std::ssize(motion.names), motion.positions_m);
  if (reader.ok() && !IsWholeOrMissing(motion.positions_m)) {
    reader.Fail(core::DataLoss("motion: a marker with an invalid position"));
  }
  return motion;
}

}  // namespace

absl::Status EncodeMotion(const core::MotionFile& file, ByteSink& sink) {
  FieldWriter writer(sink);
  writer.Put(kMotionVersion);
  PutReport(writer, file.report);
  writer.PutText(file.take);
  if (const auto* const joints = std::get_if<core::JointMotion>(&file.motion)) {
    writer.Put(kJoints);
    writer.Put(joints->frame_rate_hz);
    StringSink skeleton;
    MOTIONDB_RETURN_IF_ERROR(EncodeSkeleton(*joints->skeleton, skeleton));
    writer.PutText(skeleton.bytes());
    PutRows(writer, joints->angles);
    return writer.status();
  }
  const auto& markers = std::get<core::MarkerMotion>(file.motion);
  writer.Put(kMarkers);
  writer.Put(markers.frame_rate_hz);
  writer.Put(std::int32_t{markers.first_frame});
  writer.PutCount(markers.names.size());
  for (const std::string& name : markers.names) writer.PutText(name);
  PutRows(writer, markers.positions_m);
  return writer.status();
}

absl::StatusOr<core::MotionFile> DecodeMotion(ByteSource& source) {
  FieldReader reader(source);
  if (const auto version = reader.Get<std::uint32_t>(); reader.ok() && version != kMotionVersion) {
    return core::DataLoss("motion: expected version {}, got {}", kMotionVersion, version);
  }
  core::MotionFile file;
  file.report = GetReport(reader);
  file.take = GetShortText(reader);
  const auto kind = reader.Get<std::uint8_t>();
  double frame_rate_hz = 0;
  if (kind == kJoints) {
    core::JointMotion motion = GetJointMotion(reader);
    frame_rate_hz = motion.frame_rate_hz;
    file.motion = std::move(motion);
  } else if (kind == kMarkers) {
    core::MarkerMotion motion = GetMarkerMotion(reader);
    frame_rate_hz = motion.frame_rate_hz;
    file.motion = std::move(motion);
  } else {
    reader.Fail(core::DataLoss("motion: unknown kind {}", kind));
  }
  if (reader.ok() && !core::IsFrameRate(frame_rate_hz)) {
    reader.Fail(core::DataLoss("motion: invalid frame rate"));
  }
  MOTIONDB_RETURN_IF_ERROR(reader.Finish());
  return file;
}

}  // namespace motiondb::storage
