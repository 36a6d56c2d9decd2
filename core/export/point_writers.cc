#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "core/export/file_bytes.h"
#include "core/export/writers.h"
#include "core/format/conventions.h"
#include "core/format/text_scanner.h"
#include "core/motion/error.h"

namespace motiondb::core {
namespace {

constexpr float kMaxCoordinate_m = 1e12F;  // far below what readers accept, in any unit

std::string NameInText(const std::string& name) {
  std::string plain = name;
  for (char& c : plain) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '_';
  }
  plain = ToUtf8(plain);
  const auto first = plain.find_first_not_of(' ');
  if (first == plain.npos) return "";
  return plain.substr(first, plain.find_last_not_of(' ') - first + 1);
}

}  // namespace

absl::Status CheckWritable(std::string_view format, const MarkerMotion& motion) {
  if (motion.names.empty()) return InvalidArgument("{}: the motion has no point", format);
  if (motion.positions_m.rows() == 0) return InvalidArgument("{}: the motion has no frame", format);
  if (!IsFrameRate(motion.frame_rate_hz)) {
    return InvalidArgument("{}: expected a frame rate from 0.001 to 100000 Hz, found {}", format,
                           motion.frame_rate_hz);
  }
  const std::ptrdiff_t columns = 3 * std::ssize(motion.names);
  if (motion.positions_m.cols() != columns) {
    return InvalidArgument("{}: expected {} columns, three a point, found {}", format, columns,
                           motion.positions_m.cols());
  }
  for (Eigen::Index frame = 0; frame < motion.positions_m.rows(); ++frame) {
    for (std::size_t point = 0; point < motion.names.size(); ++point) {
      const auto at =
          motion.positions_m.block<1, 3>(frame, 3 * static_cast<Eigen::Index>(point)).array();
      const auto missing = at.isNaN().count();
      if (missing == 3) continue;
      if (missing > 0) {
        return InvalidArgument("{}: frame {}: expected all three coordinates of '{}' or none",
                               format, frame, Shown(motion.names[point]));
      }
      if ((at.abs() <= kMaxCoordinate_m).all()) continue;
      return InvalidArgument("{}: frame {}: expected coordinates of '{}' of at most {:g} m", format,
                             frame, Shown(motion.names[point]), kMaxCoordinate_m);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> WritablePointNames(std::string_view format,
                                                            const MarkerMotion& motion) {
  MOTIONDB_RETURN_IF_ERROR(CheckWritable(format, motion));
  std::vector<std::string> names;
  names.reserve(motion.names.size());
  for (const std::string& name : motion.names) {
    names.push_back(NameInText(name));
    if (names.back().empty()) {
      return InvalidArgument("{}: expected a name for point {}", format, names.size());
    }
  }
  std::unordered_set<std::string_view> seen;
  for (const std::string& name : names) {
    if (seen.insert(name).second) continue;
    return InvalidArgument("{}: two points would be named '{}'", format, Shown(name));
  }
  return names;
}

namespace {

constexpr std::size_t kMaxTablePoints = 65'535;

// Returns the cell in quotes if it has a character that separates cells in any variant of CSV.
std::string QuotedCell(std::string_view text) {
  if (text.find_first_of(",;\"") == text.npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c;
    if (c == '"') quoted += c;
  }
  return quoted + '"';
}

}  // namespace

absl::StatusOr<std::string> WritePointTable(const MarkerMotion& motion) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                            WritablePointNames("point table", motion));
  if (names.size() > kMaxTablePoints) {
    return InvalidArgument("point table: expected at most {} points, found {}", kMaxTablePoints,
                           names.size());
  }
  std::string text = "time_s";
  for (const std::string& name : names) {
    for (const char axis : {'x', 'y', 'z'}) {
      text += ',' + QuotedCell(fmt::format("{}_{}_m", name, axis));
    }
  }
  text += '\n';
  for (Eigen::Index frame = 0; frame < motion.positions_m.rows(); ++frame) {
    const std::size_t begin = text.size();
    fmt::format_to(std::back_inserter(text), "{}",
                   static_cast<double>(frame) / motion.frame_rate_hz);
    for (const float value : motion.positions_m.row(frame)) {
      text += ',';
      // Without "-0".
      if (!std::isnan(value)) {
        fmt::format_to(std::back_inserter(text), "{}", value == 0 ? 0 : value);
      }
    }
    text += '\n';
    if (frame == 0) ReserveFrames(text, text.size() - begin, motion.positions_m.rows() - 1);
  }
  return text;
}

namespace {

constexpr std::size_t kMaxTrcPoints = 65'535;
constexpr double kTrcUnitsPerMetre = 1000;

// Writes millimetres, without "-0".
void PutMillimetres(std::string& text, float metres) {
  const double value = kTrcUnitsPerMetre * static_cast<double>(metres);
  fmt::format_to(std::back_inserter(text), "\t{:.9g}", value == 0 ? 0 : value);
}

std::string TrcHeaderText(const MarkerMotion& motion, const std::vector<std::string>& names) {
  const double rate = motion.frame_rate_hz;
  const auto frames = motion.positions_m.rows();
  std::string text = "PathFileType\t4\t(X/Y/Z)\tmotion.trc\n";
  text +=
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
      "OrigNumFrames\n";
  text += fmt::format("{}\t{}\t{}\t{}\tmm\t{}\t1\t{}\n", rate, rate, frames, names.size(), rate,
                      frames);
  text += "Frame#\tTime";
  for (const std::string& name : names) text += '\t' + name + "\t\t";
  text += "\n\t";
  for (std::size_t point = 1; point <= names.size(); ++point) {
    fmt::format_to(std::back_inserter(text), "\tX{0}\tY{0}\tZ{0}", point);
  }
  return text + "\n\n";
}

}  // namespace

absl::StatusOr<std::string> WriteTrc(const MarkerMotion& motion) {
  MOTIONDB_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                            WritablePointNames("TRC", motion));
  if (names.size() > kMaxTrcPoints) {
    return InvalidArgument("TRC: expected at most {} points, found {}", kMaxTrcPoints,
                           names.size());
  }
  std::string text = TrcHeaderText(motion, names);
  for (Eigen::Index frame = 0; frame < motion.positions_m.rows(); ++frame) {
    const std::size_t begin = text.size();
    fmt::format_to(std::back_inserter(text), "{}\t{}", frame + 1,
                   static_cast<double>(frame) / motion.frame_rate_hz);
    for (Eigen::Index c = 0; c < motion.positions_m.cols(); c += 3) {
      const auto at = motion.positions_m.block<1, 3>(frame, c);
      if (std::isnan(at[0])) {
        text += "\t\t\t";
        continue;
      }
      // The file's y is up: x, z, -y of the world.
      PutMillimetres(text, at[0]);
      PutMillimetres(text, at[2]);
      PutMillimetres(text, -at[1]);
    }
    text += '\n';
    if (frame == 0) ReserveFrames(text, text.size() - begin, motion.positions_m.rows() - 1);
  }
  return text;
}

}  // namespace motiondb::core
