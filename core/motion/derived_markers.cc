#include "core/motion/derived_markers.h"

#include <algorithm>
#include <cmath>

#include "core/motion/error.h"
#include "core/motion/states.h"

namespace motiondb::core {
namespace {

constexpr DerivedMarker kDerived[] = {
    {"LToe", "LAnkle", 0.14, -0.07},   {"RToe", "RAnkle", 0.14, -0.07},
    {"LHeel", "LAnkle", -0.05, -0.06}, {"RHeel", "RAnkle", -0.05, -0.06},
    {"Head", "Neck", 0.02, 0.22},      {"HeadTop", "Neck", 0.03, 0.33},
};

// Returns the index of a marker; -1 if the set does not have it.
int Find(const MarkerSet& set, const char* marker) {
  const auto found = std::ranges::find(set.markers, marker);
  return found == set.markers.end() ? -1 : static_cast<int>(found - set.markers.begin());
}

}  // namespace

std::span<const DerivedMarker> DerivedMarkers() { return kDerived; }

absl::Status AddDerivedMarkers(const MarkerSet& set, double leg_length_m, MarkerMotion& motion,
                               std::vector<std::string>& notes) {
  const auto is_missing = [&](int marker) {
    return marker >= 0 && motion.positions_m.middleCols<3>(3 * marker).array().isNaN().all();
  };
  std::string names;
  RootPath path;
  for (const auto& [name, from, front, up] : kDerived) {
    const int marker = Find(set, name);
    const int base = Find(set, from);
    if (base < 0 || !is_missing(marker) || is_missing(base)) continue;
    if (path.rows() == 0) {
      MOTIONDB_ASSIGN_OR_RETURN(path, ReferenceFrames(set, motion));
    }
    for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
      const double heading = path(t, 2);
      const Eigen::Vector3d offset(std::cos(heading) * front, std::sin(heading) * front, up);
      motion.positions_m.row(t).segment<3>(3 * marker) =
          motion.positions_m.row(t).segment<3>(3 * base) +
          (leg_length_m * offset).transpose().cast<float>();
    }
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  if (!names.empty()) notes.push_back("derived from the proportions of a person: " + names);
  return absl::OkStatus();
}

}  // namespace motiondb::core
