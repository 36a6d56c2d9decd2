#include "core/motion/mirror.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

namespace motiondb::core {
namespace {

constexpr std::pair<std::string_view, std::string_view> kSides[] = {
    {"Left", "Right"}, {"left", "right"}, {"L", "R"}, {"l", "r"}};

// `vectors`: number of 3-vectors of each marker.
FrameMatrix Mirror(const std::vector<int>& other_sides, const FrameMatrix& rows, int vectors) {
  FrameMatrix mirrored(rows.rows(), rows.cols());
  for (std::size_t m = 0; m < other_sides.size(); ++m) {
    for (int v = 0; v < vectors; ++v) {
      const auto to = 3 * (static_cast<Eigen::Index>(m) * vectors + v);
      const auto from = 3 * (static_cast<Eigen::Index>(other_sides[m]) * vectors + v);
      mirrored.middleCols<3>(to) = rows.middleCols<3>(from);
      mirrored.col(to + 1) *= -1;
    }
  }
  return mirrored;
}

}  // namespace

std::vector<int> OtherSides(const std::vector<std::string>& markers) {
  std::map<std::string, int, std::less<>> index;
  for (std::size_t m = 0; m < markers.size(); ++m) index[markers[m]] = static_cast<int>(m);
  const auto find = [&](const std::string& name, std::string_view here, std::string_view there) {
    if (!name.starts_with(here)) return -1;
    const auto other = index.find(std::string(there) + name.substr(here.size()));
    return other == index.end() ? -1 : other->second;
  };
  std::vector<int> others;
  bool any = false;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    int other = -1;
    for (const auto& [left, right] : kSides) {
      if (other < 0) other = find(markers[m], left, right);
      if (other < 0) other = find(markers[m], right, left);
    }
    any = any || other >= 0;
    others.push_back(other >= 0 ? other : static_cast<int>(m));
  }
  // Keep only mutual pairs.
  for (std::size_t m = 0; m < others.size(); ++m) {
    if (others[others[m]] != static_cast<int>(m)) others[m] = static_cast<int>(m);
  }
  return any ? others : std::vector<int>();
}

FrameMatrix MirrorPositions(const std::vector<int>& other_sides, const FrameMatrix& positions) {
  return Mirror(other_sides, positions, 1);
}

FrameMatrix MirrorStates(const std::vector<int>& other_sides, const FrameMatrix& states) {
  return Mirror(other_sides, states, 2);
}

}  // namespace motiondb::core
