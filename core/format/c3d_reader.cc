#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/format/c3d_file.h"
#include "core/format/conventions.h"
#include "core/format/readers.h"
#include "core/format/text_scanner.h"

namespace motiondb::core {
namespace {

constexpr double kMaxCoordinate = 1e18;  // as in text files

// Byte offsets in the header of a file.
constexpr std::size_t kParameterBlockAt = 0;
constexpr std::size_t kKeyAt = 1;
constexpr std::size_t kPointCountAt = 2;
constexpr std::size_t kAnalogCountAt = 4;
constexpr std::size_t kFirstFrameAt = 6;
constexpr std::size_t kLastFrameAt = 8;
constexpr std::size_t kScaleAt = 12;
constexpr std::size_t kDataBlockAt = 16;
constexpr std::size_t kAnalogRatioAt = 18;
constexpr std::size_t kRateAt = 20;

// Position and encoding of the points in the file.
struct PointLayout {
  std::size_t data = 0;          // offset of the first frame
  std::size_t frame_stride = 0;  // bytes
  std::size_t analog = 0;        // samples in a frame
  Eigen::Index frames = 0;
  double first_frame = 1;
  int points = 0;
  bool real = false;
  double scale = 1;  // of integers
  double rate_hz = 0;
};

struct ParameterSection {
  std::size_t start = 0;
  std::size_t end = 0;
  C3dProcessor processor = C3dProcessor::kIntel;
};

absl::StatusOr<ParameterSection> FindParameters(SourceFile file) {
  const C3dBytes bytes(file, C3dProcessor::kIntel);  // single bytes do not depend on the processor
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(0, kC3dBlock, "header"));
  constexpr int kKey = 0x50;
  if (bytes.Byte(kKeyAt) != kKey) {
    return bytes.Error(kKeyAt, "expected the key of C3D files (80), found {}", bytes.Byte(kKeyAt));
  }
  const std::size_t block = bytes.Byte(kParameterBlockAt);
  if (block < 2) {
    return bytes.Error(kParameterBlockAt, "expected the parameters' block (2 or more), found {}",
                       block);
  }
  ParameterSection section{.start = (block - 1) * kC3dBlock};
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(section.start, kC3dBlock, "parameters"));
  const std::size_t blocks = std::max<std::size_t>(1, bytes.Byte(section.start + 2));
  section.end = section.start + blocks * kC3dBlock;
  MOTIONDB_RETURN_IF_ERROR(bytes.Require(section.start, blocks * kC3dBlock, "parameters"));
  const int processor = bytes.Byte(section.start + 3);
  if (processor < 84 || processor > 86) {
    return bytes.Error(section.start + 3,
                       "expected a processor of 84 (Intel), 85 (DEC) or 86 (MIPS), found {}",
                       processor);
  }
  section.processor = static_cast<C3dProcessor>(processor);
  return section;
}

// Reads an integer of TRIAL, stored in two words.
std::optional<double> LongWord(const C3dParameters& parameters, const std::string& name) {
  const auto low = parameters.Number("TRIAL", name, 0);
  const auto high = parameters.Number("TRIAL", name, 1);
  if (!low || !high) return std::nullopt;
  return *low + 65536 * *high;
}

struct C3dFrames {
  double first = 1;
  double count = 0;
};

// The header counts frames in 16 bits; parameters have the length of longer recordings.
C3dFrames FindFrames(const C3dBytes& bytes, const C3dParameters& parameters) {
  constexpr int kFull = 65535;
  const int first = bytes.Word(kFirstFrameAt);
  const int last = bytes.Word(kLastFrameAt);
  const double in_header = last - first + 1;
  const std::optional<double> frames = parameters.Number("POINT", "FRAMES");
  if (last < kFull && last >= first && frames != kFull)
    return {static_cast<double>(first), in_header};
  const auto start = LongWord(parameters, "ACTUAL_START_FIELD");
  const auto end = LongWord(parameters, "ACTUAL_END_FIELD");
  if (start && end && *end >= *start) return {*start, *end - *start + 1};
  const auto long_frames = parameters.Number("POINT", "LONG_FRAMES");
  return {static_cast<double>(first), long_frames ? *long_frames : frames.value_or(in_header)};
}

bool IsC3dScale(double scale) { return std::abs(scale) > 0 && std::abs(scale) < 1e9; }

// Returns the parameter POINT:NAME, or the header's value if the parameter does not exist or is
// not usable, which is noted.
double PreferParameter(const C3dParameters& parameters, const char* name, double in_header,
                       bool (*is_usable)(double), std::vector<std::string>& notes) {
  const double value = parameters.Number("POINT", name).value_or(in_header);
  if (is_usable(value) || !is_usable(in_header)) return value;
  notes.push_back(fmt::format("POINT:{} is {}: {} of the header used", name, value, in_header));
  return in_header;
}

absl::StatusOr<PointLayout> ReadLayout(const C3dBytes& bytes, const C3dParameters& parameters,
                                       std::vector<std::string>& notes) {
  PointLayout layout;
  layout.points = bytes.Word(kPointCountAt);
  if (layout.points == 0) {
    return bytes.Error(kPointCountAt, "expected at least one point, found 0");
  }
  const double used = parameters.Number("POINT", "USED").value_or(layout.points);
  if (used != layout.points) {
    return bytes.Error(kPointCountAt, "expected {} points, as in POINT:USED, found {}", used,
                       layout.points);
  }
  const C3dFrames range = FindFrames(bytes, parameters);
  if (!(range.count >= 1 && range.count <= std::numeric_limits<int>::max())) {
    return bytes.Error(kFirstFrameAt, "expected at least one frame, found {}", range.count);
  }
  layout.first_frame = range.first;
  layout.frames = static_cast<Eigen::Index>(range.count);

  layout.scale = PreferParameter(parameters, "SCALE", bytes.Real(kScaleAt), IsC3dScale, notes);
  if (!IsC3dScale(layout.scale)) {
    return bytes.Error(kScaleAt, "expected a scale that is finite and not 0, found {}",
                       layout.scale);
  }
  layout.real = layout.scale < 0;
  layout.rate_hz = PreferParameter(parameters, "RATE", bytes.Real(kRateAt), IsFrameRate, notes);
  if (!IsFrameRate(layout.rate_hz)) {
    return bytes.Error(kRateAt, "expected a frame rate from 0.001 to 100000 Hz, found {}",
                       layout.rate_hz);
  }
  const std::size_t block = bytes.Word(kDataBlockAt);
  if (block < 2) {
    return bytes.Error(kDataBlockAt, "expected the data's block (2 or more), found {}", block);
  }
  layout.data = (block - 1) * kC3dBlock;
  layout.analog = bytes.Word(kAnalogCountAt);
  layout.frame_stride =
      (4 * static_cast<std::size_t>(layout.points) + layout.analog) * (layout.real ? 4 : 2);
  MOTIONDB_RETURN_IF_ERROR(
      bytes.Require(layout.data, static_cast<std::size_t>(layout.frames) * layout.frame_stride,
                    fmt::format("{} frames", layout.frames)));
  return layout;
}

// Reads one point: x, y, z and a word that is negative if the point is invalid. Returns false if a
// coordinate is infinite or implausible.
bool ReadPoint(const C3dBytes& bytes, const PointLayout& layout, std::size_t offset,
               float* position) {
  double xyz[3];
  bool invalid = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    xyz[axis] = layout.real ? bytes.Real(offset + 4 * axis)
                            : layout.scale * bytes.SignedWord(offset + 2 * axis);
    invalid |= std::isnan(xyz[axis]);
  }
  invalid |= layout.real ? bytes.Real(offset + 12) < 0 : bytes.SignedWord(offset + 6) < 0;
  invalid |= xyz[0] == 0 && xyz[1] == 0 && xyz[2] == 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!invalid && !(std::abs(xyz[axis]) <= kMaxCoordinate)) return false;
    position[axis] =
        invalid ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(xyz[axis]);
  }
  return true;
}

absl::StatusOr<FrameMatrix> ReadPoints(const C3dBytes& bytes, const PointLayout& layout,
                                       const std::vector<C3dMarker>& markers) {
  const std::size_t point_size = layout.real ? 16 : 8;
  FrameMatrix positions(layout.frames, 3 * static_cast<Eigen::Index>(markers.size()));
  float* position = positions.data();
  for (Eigen::Index frame = 0; frame < layout.frames; ++frame) {
    const std::size_t start = layout.data + static_cast<std::size_t>(frame) * layout.frame_stride;
    for (const C3dMarker& marker : markers) {
      const std::size_t offset = start + marker.point * point_size;
      if (!ReadPoint(bytes, layout, offset, position)) {
        return bytes.Error(offset, "expected a finite position of '{}' in frame {}", marker.name,
                           layout.first_frame + static_cast<double>(frame));
      }
      position += 3;
    }
  }
  return positions;
}

// Notes what the file has besides points.
void NoteSkipped(const C3dBytes& bytes, const C3dParameters& parameters, const PointLayout& layout,
                 std::vector<std::string>& notes) {
  std::string skipped;
  if (layout.analog > 0) {
    // The frame has several samples of each channel. Some headers do not have their number.
    const double used = parameters.Number("ANALOG", "USED").value_or(0);
    const double samples = static_cast<double>(layout.analog);
    const double ratio = used >= 1 && std::fmod(samples, used) == 0
                             ? samples / used
                             : std::max<double>(1, bytes.Word(kAnalogRatioAt));
    skipped =
        fmt::format("{:.0f} analog channels at {:.6g} Hz", samples / ratio, ratio * layout.rate_hz);
  }
  const double platforms = parameters.Number("FORCE_PLATFORM", "USED").value_or(0);
  if (platforms >= 1) {
    skipped += fmt::format("{}{:.0f} force platforms", skipped.empty() ? "" : ", ", platforms);
  }
  if (!skipped.empty()) notes.push_back("skipped " + skipped);
}

std::optional<UpAxis> StatedUpAxis(const C3dParameters& parameters) {
  const std::vector<std::string_view> axis = parameters.Strings("POINT", "Y_SCREEN");
  if (axis.empty()) return std::nullopt;
  if (IsKeyword(axis[0], "+x")) return UpAxis::kX;
  if (IsKeyword(axis[0], "+y")) return UpAxis::kY;
  if (IsKeyword(axis[0], "+z")) return UpAxis::kZ;
  if (IsKeyword(axis[0], "-x")) return UpAxis::kMinusX;
  if (IsKeyword(axis[0], "-y")) return UpAxis::kMinusY;
  if (IsKeyword(axis[0], "-z")) return UpAxis::kMinusZ;
  return std::nullopt;
}

void DecideConventions(const C3dParameters& parameters, const std::vector<std::string>& names,
                       const FrameMatrix& positions, const ReadOptions& options,
                       SourceReport& report) {
  constexpr double kMillimetre = 0.001;
  const std::vector<std::string_view> units = parameters.Strings("POINT", "UNITS");
  const std::string_view unit = units.empty() ? std::string_view() : units[0];
  const std::optional<double> stated = MetresPerC3dUnit(unit);
  if (!unit.empty() && !stated && !options.metres_per_unit) {
    report.notes.push_back(fmt::format("unknown unit '{}'", Shown(unit)));
  }
  const DeducedConventions deduced = DeduceConventions(names, positions);
  DecideUnit(options.metres_per_unit, stated, deduced, kMillimetre, report);
  DecideUpAxis({.given = options.up_axis,
                .stated = StatedUpAxis(parameters),
                .deduced = deduced.up_axis,
                .fallback = UpAxis::kZ},
               report);
}

}  // namespace

absl::StatusOr<MotionFile> ReadC3d(SourceFile file, const ReadOptions& options) {
  MOTIONDB_ASSIGN_OR_RETURN(const ParameterSection section, FindParameters(file));
  const C3dBytes bytes(file, section.processor);
  // Some files have a wrong block count, so parameters extend at least up to the data.
  const std::size_t data = bytes.Word(kDataBlockAt) * kC3dBlock;
  MOTIONDB_ASSIGN_OR_RETURN(
      const C3dParameters parameters,
      C3dParameters::Read(bytes, section.start,
                          std::max(section.end, std::max(data, kC3dBlock) - kC3dBlock)));
  MotionFile read;
  SourceReport& report = read.report;
  MOTIONDB_ASSIGN_OR_RETURN(const PointLayout layout, ReadLayout(bytes, parameters, report.notes));
  const std::vector<C3dMarker> markers = C3dMarkers(parameters, layout.points, report.notes);
  if (markers.empty()) {
    return bytes.Error(kPointCountAt, "expected at least one marker, found computed points only");
  }
  if (layout.first_frame != 1) {
    report.notes.push_back(fmt::format("frames start at {}", layout.first_frame));
  }
  NoteSkipped(bytes, parameters, layout, report.notes);
  MOTIONDB_ASSIGN_OR_RETURN(FrameMatrix positions, ReadPoints(bytes, layout, markers));
  std::vector<std::string> names;
  names.reserve(markers.size());
  for (const C3dMarker& marker : markers) names.push_back(marker.name);
  DecideConventions(parameters, names, positions, options, report);
  ToWorld(report, positions);
  read.motion = MarkerMotion{.names = std::move(names),
                             .frame_rate_hz = options.frame_rate_hz.value_or(layout.rate_hz),
                             .positions_m = std::move(positions)};
  return read;
}

}  // namespace motiondb::core
