#include "core/format/motion_file.h"

#include <algorithm>
#include <cmath>

#include "core/format/conventions.h"
#include "core/format/gunzip.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

// Counts the words of a TRC file's first non-blank lines, up to the marker names.
std::int64_t WordsOfHeader(std::string_view text) {
  constexpr int kLines = 5;
  std::int64_t words = 0;
  for (int lines = 0; lines < kLines && !text.empty();) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const auto on_line = static_cast<std::int64_t>(CountWords(text.substr(0, end)));
    words += on_line;
    lines += on_line > 0 ? 1 : 0;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

// Number of points of a C3D file, in the byte order that yields the larger number.
std::int64_t C3dPoints(std::string_view bytes) {
  if (bytes.size() < 4) return 0;
  const int low = static_cast<unsigned char>(bytes[2]);
  const int high = static_cast<unsigned char>(bytes[3]);
  return std::max(low + 256 * high, high + 256 * low);
}

absl::Status CheckNumbers(const ReadOptions& options) {
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

std::string_view NameOf(Provenance provenance) {
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

std::string_view NameOf(UpAxis up) {
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

std::string Describe(const SourceReport& report) {
  std::string line = fmt::format("unit {:.6g} m ({}), {} up ({})", report.metres_per_unit,
                                 NameOf(report.unit_provenance), NameOf(report.up_axis),
                                 NameOf(report.up_provenance));
  for (const std::string& note : report.notes) line += "; " + note;
  return line;
}

absl::Status CheckReadOptions(FileFormat format, std::string_view file_name,
                              const ReadOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckNumbers(options));
  if (options.take.empty() || InfoOf(format).has_takes) return absl::OkStatus();
  return InvalidArgument("{}: {} files have no takes, got take '{}'", file_name,
                         InfoOf(format).name, options.take);
}

absl::StatusOr<MotionFile> ReadMotionFile(FileFormat format, SourceFile file,
                                          std::optional<SourceFile> skeleton,
                                          const ReadOptions& options) {
  MOTIONDB_RETURN_IF_ERROR(CheckReadOptions(format, file.name, options));
  switch (format) {
    case FileFormat::kBvh:
      return ReadBvh(file, options);
    case FileFormat::kAmc:
      if (!skeleton) {
        return InvalidArgument("{}: expected an ASF file with its skeleton", file.name);
      }
      return ReadAmc(file, *skeleton, options);
    case FileFormat::kTrc:
      return ReadTrc(file, options);
    case FileFormat::kC3d:
      return ReadC3d(file, options);
    case FileFormat::kCsv:
      return ReadJointTable(file, skeleton, options);
    case FileFormat::kNpz:
    case FileFormat::kFbx:
    case FileFormat::kGltf:
    case FileFormat::kCollada:
      break;
  }
  return InvalidArgument("{}: {} files are read by motiondb-import", file.name,
                         InfoOf(format).name);
}

std::int64_t MaxBytesToRead(FileFormat format, SourceFile file,
                            std::optional<SourceFile> skeleton) {
  constexpr std::int64_t kJoint = 2048;  // including the temporary skeletons
  constexpr std::int64_t kName = 400;    // including the sets that make names unique
  constexpr std::int64_t kMinBoneText = 40;
  constexpr std::int64_t kC3dParameter = 300;
  constexpr std::int64_t kMaxC3dParameters = 10'000;
  const auto words = static_cast<std::int64_t>(CountWords(file.bytes));
  const auto bytes = static_cast<std::int64_t>(file.bytes.size());
  const auto joints = [](std::int64_t count) {
    return kJoint * std::min<std::int64_t>(kMaxFileJoints, count);
  };
  switch (format) {
    case FileFormat::kBvh:
      return 8 * words + joints(std::count(file.bytes.begin(), file.bytes.end(), '{'));
    case FileFormat::kAmc: {
      std::int64_t bones = 0;
      if (skeleton) {
        const std::size_t text = PlainBytes(skeleton->bytes, kMaxSkeletonBytes);
        bones = static_cast<std::int64_t>(text) / kMinBoneText;
      }
      // A growing vector, or the vector and the result.
      return 24 * words + joints(bones);
    }
    case FileFormat::kTrc:
      // Cells may be empty, so tabs count. A vector and the result, float.
      return 8 * (words + std::count(file.bytes.begin(), file.bytes.end(), '\t')) +
             kName * WordsOfHeader(file.bytes);
    case FileFormat::kC3d:
      // Three 16-bit words become three floats; the fourth is a validity flag.
      return 3 * bytes / 2 + kName * std::min(bytes / 8, C3dPoints(file.bytes)) +
             kC3dParameter * std::min(bytes / 8, kMaxC3dParameters);
    case FileFormat::kCsv:
      return MaxBytesToReadJointTable(file, skeleton);
    case FileFormat::kNpz:
    case FileFormat::kFbx:
    case FileFormat::kGltf:
    case FileFormat::kCollada:
      break;  // not read here
  }
  return 0;
}

}  // namespace motiondb::core
