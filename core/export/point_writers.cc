#include <cmath>
#include <cstddef>
#include <unordered_set>
#include <utility>

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

}  // namespace motiondb::core
