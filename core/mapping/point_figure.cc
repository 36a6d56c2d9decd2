#include <algorithm>

#include "core/mapping/figure_search.h"

namespace motiondb::core {

Figure FindByNames(const PointCloud& points, const std::vector<NameMeaning>& meanings) {
  struct Choice {
    float fit;
    int point;
    Role role;
  };
  constexpr float kMinFit = 0.4F;
  std::vector<Choice> choices;
  for (int p = 0; p < points.count(); ++p) {
    for (std::size_t r = 0; r < kRoleCount; ++r) {
      const float fit = meanings[p].fit[r];
      if (fit >= kMinFit) choices.push_back({fit, p, static_cast<Role>(r)});
    }
  }
  // The best names first; of equal ones, the first in the file.
  std::ranges::stable_sort(choices, std::ranges::greater(), &Choice::fit);
  Figure figure;
  figure.names = points.names;
  std::vector<bool> is_used(points.count(), false);
  for (const Choice& choice : choices) {
    const Side side = meanings[choice.point].side;
    const bool is_sided = choice.role >= Role::kHip;
    if (is_sided != (side != Side::kNone) || is_used[choice.point]) continue;
    RolePoint& point = figure.at(choice.role, side);
    if (choice.role == Role::kSpine) {
      figure.spine.push_back(choice.point);
    } else if (point.is_found()) {
      continue;
    }
    point = {choice.point, 0.9 * choice.fit};
    is_used[choice.point] = true;
  }
  std::ranges::sort(figure.spine);
  return figure;
}

}  // namespace motiondb::core
