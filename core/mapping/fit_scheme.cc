#include "core/mapping/fit_scheme.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string_view>

#include "core/mapping/figure.h"
#include "core/mapping/figure_mapping.h"
#include "core/mapping/skin_markers.h"
#include "core/motion/error.h"
#include "core/motion/marker_set.h"

namespace motiondb::core {
namespace {

constexpr char kStandardSet[] = "standard34";

// Returns the necessary role with the lowest confidence.
std::string LowestConfidence(const Figure& figure) {
  double lowest = 2;
  std::string text;
  for (const Role role : kNecessaryRoles) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const RolePoint& point = figure.at(role, side);
      if (point.confidence >= lowest) continue;
      lowest = point.confidence;
      text =
          fmt::format("{:.2f}, {} '{}'", lowest, RoleName(role, side), figure.names[point.index]);
    }
  }
  return text;
}

// Returns whether a mapping is meant for these points, even if one of its rules uses another one.
bool HasFittingSignature(const MarkerScheme& scheme, const std::vector<std::string>& names) {
  const std::set<std::string_view> known(names.begin(), names.end());
  return std::ranges::any_of(scheme.mappings, [&](const MarkerMapping& mapping) {
    return std::ranges::all_of(mapping.signature,
                               [&](const std::string& name) { return known.contains(name); });
  });
}

}  // namespace

absl::StatusOr<AutomaticMapping> MapAutomatically(const MarkerSet& set, const PointCloud& points) {
  if (points.parents.empty()) {
    const SkinMarkers skin(points.names);
    if (skin.has_legs()) {
      return AutomaticMapping{MappingFrom(set, StandardMarkers(skin), points.names),
                              fmt::format("optical markers mapped automatically ({} anatomical "
                                          "landmarks of {} markers)",
                                          skin.count(), points.count()),
                              {}};
    }
  }
  const Figure figure = FindFigure(points);
  MOTIONDB_ASSIGN_OR_RETURN(MarkerMapping mapping, MapFigure(set, figure, points));
  const bool has_hierarchy = !points.parents.empty();
  std::vector<std::string> derived = DerivedMarkersOf(figure, has_hierarchy);
  // Represent derives the markers that have no rule at all, and reports them.
  std::erase_if(derived, [&](const std::string& marker) {
    const int at = set.FindMarker(marker);
    return at < 0 || mapping.rules[at].points.empty();
  });
  return AutomaticMapping{
      std::move(mapping),
      fmt::format("{} mapped automatically (lowest confidence {})",
                  has_hierarchy ? "joints" : "points", LowestConfidence(figure)),
      std::move(derived)};
}

absl::Status CheckPointNames(const std::vector<std::string>& names) {
  if (SkinMarkers(names).has_legs()) return absl::OkStatus();
  if (IsComplete(FindByNames({.names = names}, NameMeanings(names)))) return absl::OkStatus();
  return InvalidArgument(
      "the {} names ('{}', ...) are neither of a known marker set nor of hips, knees, ankles, "
      "shoulders, elbows and wrists of both sides",
      names.size(), names.empty() ? "" : names.front());
}

absl::StatusOr<MarkerScheme> FitScheme(const MarkerScheme& scheme, const Motion& motion,
                                       FitFor purpose, std::string* note) {
  PointCloud points = SamplePoints(motion, 0);
  const auto bound = BindMapping(scheme, points.names);
  if (bound.ok()) return scheme;
  if (scheme.set.name != kStandardSet || HasFittingSignature(scheme, points.names)) {
    return bound.status();
  }
  points = SamplePoints(motion);
  auto found = MapAutomatically(scheme.set, points);
  if (!found.ok()) {
    return InvalidArgument(
        "no mapping of marker set '{}' fits, and the {} {} ('{}', ...) cannot be mapped "
        "automatically: {}; write a mapping (motiondb inspect FILE --write-mapping MAPPING) and "
        "add it (motiondb mapping add DB MAPPING)",
        scheme.set.name, points.count(), points.parents.empty() ? "markers" : "joints",
        points.names.empty() ? "" : points.names.front(), std::string(found.status().message()));
  }
  if (purpose == FitFor::kQuery) {
    for (std::size_t m = 0; m < scheme.set.markers.size(); ++m) {
      const bool is_derived =
          std::ranges::find(found->derived, scheme.set.markers[m]) != found->derived.end();
      if (is_derived) found->mapping.rules[m] = {};
    }
  } else if (!found->derived.empty()) {
    found->note += fmt::format("; derived from other points: {}", fmt::join(found->derived, ", "));
  }
  if (note != nullptr) *note = std::move(found->note);
  return MarkerScheme{scheme.set, {}, {std::move(found->mapping)}};
}

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
