#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>

#include "core/export/frame_text.h"
#include "core/export/writers.h"
#include "core/motion/error.h"

namespace motiondb::core {
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

}  // namespace motiondb::core
