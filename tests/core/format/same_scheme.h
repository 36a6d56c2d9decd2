// Comparison of marker schemes.
#pragma once

#include <catch2/catch.hpp>
#include <vector>

#include "core/motion/marker_set.h"

namespace motiondb::tests {

inline void CheckSame(const std::vector<core::MarkerRule>& a,
                      const std::vector<core::MarkerRule>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t m = 0; m < a.size(); ++m) {
    CAPTURE(m);
    CHECK(a[m].offset_joint == b[m].offset_joint);
    CHECK(a[m].offset == b[m].offset);
    REQUIRE(a[m].points.size() == b[m].points.size());
    for (std::size_t p = 0; p < a[m].points.size(); ++p) {
      CHECK(a[m].points[p].name == b[m].points[p].name);
      CHECK(a[m].points[p].weight == b[m].points[p].weight);
    }
  }
}

inline void CheckSame(const core::MarkerMapping& a, const core::MarkerMapping& b) {
  CHECK(a.name == b.name);
  CHECK(a.signature == b.signature);
  CheckSame(a.rules, b.rules);
}

inline void CheckSame(const core::MarkerScheme& a, const core::MarkerScheme& b) {
  CHECK(a.set.name == b.set.name);
  CHECK(a.set.markers == b.set.markers);
  CHECK(a.set.landmarks.left_hip == b.set.landmarks.left_hip);
  CHECK(a.set.landmarks.right_hip == b.set.landmarks.right_hip);
  CHECK(a.set.landmarks.legs == b.set.landmarks.legs);
  CheckSame(a.default_rules, b.default_rules);
  REQUIRE(a.mappings.size() == b.mappings.size());
  for (std::size_t i = 0; i < a.mappings.size(); ++i) CheckSame(a.mappings[i], b.mappings[i]);
}

}  // namespace motiondb::tests
