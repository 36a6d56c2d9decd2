// A small database for planning: the walking figure, straight and in bends to both sides.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/model/model_builder.h"
#include "tests/core/planning/walking_figure.h"

namespace motiondb::tests {

// Bends a walk along x to an arc of this curvature (1/m, to the left). Markers at rest stay at
// rest.
inline void Bend(double curvature, core::MarkerMotion& motion) {
  if (curvature == 0) return;
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    for (Eigen::Index m = 0; m < motion.positions_m.cols() / 3; ++m) {
      const double along = curvature * motion.positions_m(t, 3 * m);
      const double radius = 1 / curvature - motion.positions_m(t, 3 * m + 1);
      motion.positions_m(t, 3 * m) = static_cast<float>(radius * std::sin(along));
      motion.positions_m(t, 3 * m + 1) =
          static_cast<float>(1 / curvature - radius * std::cos(along));
    }
  }
}

inline core::MarkerScheme WalkerScheme() { return {WalkerSet(), {}}; }

// Clips "straight", "left-1" ... with labels "straight" and "bend", 4 s each at 60 Hz.
inline const core::Model& WalkingDatabase() {
  static const core::Model kModel = [] {
    std::vector<core::BuildInput> inputs;
    const auto add = [&](const std::string& id, const std::string& label, double curvature,
                         double speed) {
      WalkingFigure figure;
      figure.seconds = 4;
      figure.speed_m_s = speed;
      core::MarkerMotion motion = figure.Motion();
      Bend(curvature, motion);
      auto states = core::ComputeStates(WalkerSet(), motion);
      REQUIRE(states.ok());
      inputs.push_back({id, label, *std::move(states)});
    };
    add("straight", "straight", 0, 0.7);
    add("slower", "straight", 0, 0.6);
    for (const double curvature : {0.4, 0.9, 1.5}) {
      add("left-" + std::to_string(curvature), "bend", curvature, 0.65);
      add("right-" + std::to_string(curvature), "bend", -curvature, 0.65);
    }
    auto model = core::BuildModel({}, WalkerSet(), std::move(inputs), core::RunSerially, {});
    INFO(model.status());
    REQUIRE(model.ok());
    return *std::move(model);
  }();
  return kModel;
}

}  // namespace motiondb::tests
