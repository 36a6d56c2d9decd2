#include <catch2/catch.hpp>
#include <cmath>

#include "core/planning/goal.h"
#include "core/planning/seeded.h"

namespace motiondb::core::root_correction_test {
namespace {

double Length(const std::vector<FloorPose>& root) {
  double length = 0;
  for (std::size_t t = 1; t < root.size(); ++t) {
    length += std::hypot(root[t].x - root[t - 1].x, root[t].y - root[t - 1].y);
  }
  return length;
}

// A wandering walk.
std::vector<FloorPose> Wander(std::uint64_t seed) {
  SeededSequence random(seed);
  std::vector<FloorPose> root{{}};
  double turn = 0;
  for (int t = 0; t < 200; ++t) {
    turn = 0.9 * turn + 0.02 * (random.Next() - 0.5);
    root.push_back(root.back() * FloorPose{0.02 * random.Next(), 0, turn});
  }
  return root;
}

TEST_CASE("Floor pose: conversion to a frame and back is the identity", "[planning]") {
  const FloorPose frame{1, -2, 0.7};
  const FloorPose pose{3, 0.5, -2.1};
  const FloorPose back = frame * RelativeTo(frame, pose);
  CHECK(back.x == Approx(pose.x));
  CHECK(back.y == Approx(pose.y));
  CHECK(back.heading == Approx(pose.heading));
}

TEST_CASE("Root correction: a near goal is reached within the limits of the shift", "[planning]") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::vector<FloorPose> root = Wander(seed);
    const double length = Length(root);
    SeededSequence random(seed + 1000);
    const FloorPose offset{0.03 * length * (random.Next() - 0.5),
                           0.03 * length * (random.Next() - 0.5),
                           0.04 * length * (random.Next() - 0.5)};
    const FloorPose goal{root.back().x + offset.x, root.back().y + offset.y,
                         root.back().heading + offset.heading};
    const CorrectedRoot corrected = CorrectRoot(root, goal);
    const GoalError error = ErrorAt(corrected.poses.back(), goal);
    CHECK(error.position_m == Approx(0).margin(1e-9));
    CHECK(error.heading_rad == Approx(0).margin(1e-9));
    CHECK(corrected.largest_shift_m <= kMaxCorrection * length);
    CHECK(corrected.poses.front().x == 0);
    CHECK(corrected.poses.front().heading == 0);
  }
}

TEST_CASE("Root correction: a far goal is approached up to the limits", "[planning]") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const std::vector<FloorPose> root = Wander(seed);
    const double length = Length(root);
    const FloorPose goal{root.back().x + 1, root.back().y - 2, root.back().heading + 1};
    const CorrectedRoot corrected = CorrectRoot(root, goal);
    CHECK(corrected.largest_shift_m <= kMaxCorrection * length * (1 + 1e-9));
    CHECK(corrected.largest_shift_m <= kMaxCorrection * corrected.length_m);
    CHECK(corrected.largest_shift_m > 0.85 * kMaxCorrection * length);
    CHECK(corrected.length_m == Approx(Length(corrected.poses)));
    CHECK(corrected.turn_rad <= kMaxCorrection * length * (1 + 1e-9));
    CHECK(ErrorAt(corrected.poses.back(), goal).position_m < ErrorAt(root.back(), goal).position_m);
  }
}

TEST_CASE("Root correction: a body at rest is not moved", "[planning]") {
  std::vector<FloorPose> root = Wander(3);
  root.insert(root.begin() + 100, 30, root[100]);
  const FloorPose goal{root.back().x + 0.01, root.back().y, root.back().heading + 0.01};
  const CorrectedRoot corrected = CorrectRoot(root, goal);
  for (int t = 101; t <= 130; ++t) {
    CHECK(corrected.poses[t].x == Approx(corrected.poses[100].x).margin(1e-12));
    CHECK(corrected.poses[t].heading == Approx(corrected.poses[100].heading).margin(1e-12));
  }
  const std::vector<FloorPose> still(10);
  CHECK(CorrectRoot(still, {1, 1, 1}).largest_shift_m == 0);
}

}  // namespace
}  // namespace motiondb::core::root_correction_test
