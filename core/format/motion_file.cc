#include "core/format/motion_file.h"

#include <algorithm>
#include <cmath>

#include "core/format/amc_reader.h"
#include "core/format/bvh_reader.h"
#include "core/format/c3d_reader.h"
#include "core/format/frame_rate.h"
#include "core/format/text_scanner.h"
#include "core/format/trc_reader.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

std::string_view Word(Provenance provenance) {
  switch (provenance) {
    case Provenance::kGiven:
      return "given";
    case Provenance::kStated:
      return "stated";
    case Provenance::kDeduced:
      return "deduced";
    case Provenance::kAssumed:
      return "assumed";
  }
  return "";
}

std::string_view Word(UpAxis up) {
  switch (up) {
    case UpAxis::kX:
      return "x";
    case UpAxis::kY:
      return "y";
    case UpAxis::kZ:
      return "z";
    case UpAxis::kMinusX:
      return "-x";
    case UpAxis::kMinusY:
      return "-y";
    case UpAxis::kMinusZ:
      return "-z";
  }
  return "";
}

absl::Status CheckOptions(const ReadOptions& options) {
  if (const auto unit = options.metres_per_unit; unit && !(*unit >= 1e-9 && *unit <= 1e9)) {
    return InvalidArgument("metres_per_unit: expected a number from 1e-9 to 1e9, found {}", *unit);
  }
  if (const auto rate = options.frame_rate_hz; rate && !IsFrameRate(*rate)) {
    return InvalidArgument("frame_rate_hz: expected a rate from 0.001 to 100000 Hz, found {}",
                           *rate);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<FileFormat> FormatOfPath(std::string_view path) {
  const std::string_view extension = path.substr(std::min(path.rfind('.'), path.size()));
  if (IsKeyword(extension, ".bvh")) return FileFormat::kBvh;
  if (IsKeyword(extension, ".amc")) return FileFormat::kAmc;
  if (IsKeyword(extension, ".trc")) return FileFormat::kTrc;
  if (IsKeyword(extension, ".c3d")) return FileFormat::kC3d;
  return InvalidArgument("{}: expected a file ending in .bvh, .amc, .trc or .c3d", path);
}

std::string Describe(const SourceReport& report) {
  std::string line =
      fmt::format("unit {:.6g} m ({}), {} up ({})", report.metres_per_unit,
                  Word(report.unit_provenance), Word(report.up_axis), Word(report.up_provenance));
  for (const std::string& note : report.notes) line += "; " + note;
  return line;
}

absl::StatusOr<MotionFile> ReadMotionFile(FileFormat format, SourceFile file,
                                          std::optional<SourceFile> skeleton,
                                          const ReadOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckOptions(options));
  switch (format) {
    case FileFormat::kBvh:
      return ReadBvh(file, options);
    case FileFormat::kAmc:
      if (!skeleton) {
        return InvalidArgument("{}: expected the ASF file of its skeleton with it", file.name);
      }
      return ReadAmc(file, *skeleton, options);
    case FileFormat::kTrc:
      return ReadTrc(file, options);
    case FileFormat::kC3d:
      return ReadC3d(file, options);
  }
  return InvalidArgument("{}: expected a known file format", file.name);
}

}  // namespace motiondb::core
