#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>

#include "core/export/frame_text.h"
#include "core/export/writers.h"
#include "core/motion/error.h"

namespace motiondb::core {
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
