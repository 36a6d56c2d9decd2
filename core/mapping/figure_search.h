// The two searches of FindFigure, before sides are checked.
#pragma once

#include <optional>
#include <vector>

#include "core/mapping/figure.h"

namespace motiondb::core {

// Finds legs, arms, trunk and head in a hierarchy by names and bones. Limbs without names of sides
// are in any order. Nothing if no two pairs of limbs are like legs and arms.
std::optional<Figure> FindInHierarchy(const PointCloud& points,
                                      const std::vector<NameMeaning>& meanings);

// Finds points by their names alone.
Figure FindByNames(const PointCloud& points, const std::vector<NameMeaning>& meanings);

}  // namespace motiondb::core
