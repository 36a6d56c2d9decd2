#include "core/mapping/fit_scheme.h"

#include <algorithm>

#include "core/mapping/automatic_mapping.h"
#include "core/motion/error.h"
#include "core/motion/marker_rules.h"

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

}  // namespace

absl::StatusOr<MarkerScheme> FitScheme(const MarkerScheme& scheme, const Motion& motion,
                                       std::string* note) {
  PointCloud points = SamplePoints(motion, 0);
  const auto bound = BindMapping(scheme, points.names);
  if (bound.ok()) return scheme;
  if (scheme.set.name != kStandardSet) return bound.status();
  points = SamplePoints(motion);
  const Figure figure = FindFigure(points);
  auto mapping = MapFigure(scheme.set, figure, points);
  if (!mapping.ok()) {
    return InvalidArgument(
        "no mapping of marker set '{}' fits, and the {} {} ('{}', ...) cannot be mapped "
        "automatically: {}; add a mapping to a marker-set file",
        scheme.set.name, points.count(), points.parents.empty() ? "markers" : "joints",
        points.names.empty() ? "" : points.names.front(), std::string(mapping.status().message()));
  }
  if (note != nullptr) {
    *note = fmt::format("{} mapped automatically (lowest confidence {})",
                        points.parents.empty() ? "markers" : "joints", LowestConfidence(figure));
  }
  return MarkerScheme{scheme.set, {*std::move(mapping)}};
}

}  // namespace motiondb::core
