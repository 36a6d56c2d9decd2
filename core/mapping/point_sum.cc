#include "core/mapping/point_sum.h"

#include <algorithm>

namespace motiondb::core {

PointSum Total(const std::vector<std::pair<double, PointSum>>& sums) {
  PointSum total;
  for (const auto& [factor, sum] : sums) {
    if (sum.empty()) return {};
    for (const auto& [point, weight] : sum) total[point] += factor * weight;
  }
  std::erase_if(total, [](const auto& term) { return term.second == 0; });
  return total;
}

PointSum Between(const PointSum& a, const PointSum& b, double share) {
  return Total({{1 - share, a}, {share, b}});
}

MarkerMapping MappingFrom(const MarkerSet& set, const std::map<std::string, PointSum>& markers,
                          const std::vector<std::string>& names) {
  MarkerMapping mapping{.name = "automatic", .signature = {}, .rules = {}};
  for (const std::string& marker : set.markers) {
    MarkerRule& rule = mapping.rules.emplace_back();
    const auto sum = markers.find(marker);
    if (sum == markers.end()) continue;
    for (const auto& [point, weight] : sum->second) {
      rule.points.push_back({names[point], weight});
      if (std::ranges::find(mapping.signature, names[point]) == mapping.signature.end()) {
        mapping.signature.push_back(names[point]);
      }
    }
  }
  return mapping;
}

}  // namespace motiondb::core
