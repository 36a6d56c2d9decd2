#include "core/mapping/found_roles.h"

#include <fmt/format.h>

#include <iterator>

#include "core/mapping/figure_mapping.h"
#include "core/mapping/skin_markers.h"

namespace motiondb::core {
namespace {

constexpr const char* kLandmarkNames[] = {"sacrum",
                                          "seventh neck vertebra",
                                          "middle of the back",
                                          "top of the breastbone",
                                          "bottom of the breastbone",
                                          "forehead",
                                          "back of the head",
                                          "front of the waist",
                                          "back of the waist",
                                          "outer knee",
                                          "inner knee",
                                          "outer ankle",
                                          "inner ankle",
                                          "heel",
                                          "toe",
                                          "big toe",
                                          "small toe",
                                          "shoulder",
                                          "upper arm",
                                          "outer elbow",
                                          "inner elbow",
                                          "wrist at the thumb",
                                          "wrist at the small finger",
                                          "hand",
                                          "inner hand",
                                          "outer hand",
                                          "front of the head",
                                          "back of the head",
                                          "side of the head"};
static_assert(std::size(kLandmarkNames) == static_cast<std::size_t>(Landmark::kCount));

void AddLandmarks(const SkinMarkers& skin, std::vector<FoundRole>& found) {
  for (int l = 0; l < static_cast<int>(Landmark::kCount); ++l) {
    const auto landmark = static_cast<Landmark>(l);
    const bool is_middle = landmark < Landmark::kAsis;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (is_middle && side == Side::kRight) continue;
      const PointSum at = skin.at(landmark, side);
      if (at.size() != 1) continue;
      const char* const prefix = is_middle ? "" : side == Side::kLeft ? "left " : "right ";
      found.push_back({at.begin()->first, fmt::format("{}{}", prefix, kLandmarkNames[l]), 1});
    }
  }
}

void AddFigure(const Figure& figure, std::vector<FoundRole>& found) {
  for (const int joint : figure.spine) {
    found.push_back({joint, RoleName(Role::kSpine, Side::kNone), 1});
  }
  for (std::size_t r = 0; r < kRoleCount; ++r) {
    const auto role = static_cast<Role>(r);
    for (const Side side : {Side::kLeft, Side::kRight}) {
      if (role < Role::kHip && side == Side::kRight) continue;
      const RolePoint& point = figure.at(role, side);
      if (point.is_found()) found.push_back({point.index, RoleName(role, side), point.confidence});
    }
  }
}

}  // namespace

std::vector<FoundRole> FindRoles(const PointCloud& points) {
  std::vector<FoundRole> found;
  const SkinMarkers skin(points.names);
  if (points.parents.empty() && skin.has_legs()) {
    AddLandmarks(skin, found);
  } else {
    AddFigure(FindFigure(points), found);
  }
  return found;
}

}  // namespace motiondb::core
