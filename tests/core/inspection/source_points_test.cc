#include "core/inspection/source_points.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "core/format/marker_set_file.h"
#include "core/format/motion_file.h"
#include "core/mapping/fit_scheme.h"
#include "core/motion/marker_set.h"
#include "tests/core/format/same_scheme.h"
#include "tests/support/humanoid_bvh.h"

namespace motiondb::tests::source_points_test {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

core::Motion Humanoid() {
  auto file = core::ReadMotionFile(core::FileFormat::kBvh, {"a.bvh", HumanoidBvh(100, 60)});
  REQUIRE(file.ok());
  return std::move(file->motion);
}

// The markers of the standard set, each at a place of its own, which moves.
core::MarkerMotion StandardMarkers() {
  core::MarkerMotion motion{core::StandardScheme().set.markers, 30, {}};
  const auto columns = static_cast<Eigen::Index>(3 * motion.names.size());
  motion.positions_m = core::FrameMatrix::NullaryExpr(
      20, columns, [](Eigen::Index t, Eigen::Index c) { return 0.01F * c + 0.001F * t; });
  return motion;
}

TEST_CASE("FindSourcePoints: joints, their parents, and the markers computed from them",
          "[core][inspection]") {
  const auto found = core::FindSourcePoints(core::StandardScheme(), Humanoid());
  INFO(found.status());
  REQUIRE(found.ok());
  CHECK(!found->mapping.empty());
  const auto at = [&](const std::string& name) {
    const auto point = std::ranges::find(found->points, name, &core::SourcePoint::name);
    REQUIRE(point != found->points.end());
    return *point;
  };
  CHECK(at("Hips").parent == -1);
  CHECK(at("Hips").position_m[2] == Approx(0.93).margin(0.01));
  const core::SourcePoint knee = at("LeftLeg");
  CHECK(found->points[knee.parent].name == "LeftUpLeg");
  CHECK(std::ranges::find(knee.markers, "LKnee") != knee.markers.end());
  // Each marker of the set with a rule is named by a point.
  for (const core::SourcePoint& point : found->points) {
    CHECK(std::ranges::adjacent_find(point.markers) == point.markers.end());
  }
}

TEST_CASE("FindSourcePoints: the mapping as text is the one that is used", "[core][inspection]") {
  const core::MarkerScheme& standard = core::StandardScheme();
  // An automatic mapping and, if it is stored in the set, the mapping with its name.
  core::Motion motion = Humanoid();
  const auto fitted = core::FitScheme(standard, motion, core::FitFor::kClip);
  REQUIRE(fitted.ok());
  for (const core::MarkerScheme& scheme : {standard, *fitted}) {
    const auto found = core::FindSourcePoints(scheme, motion);
    REQUIRE(found.ok());
    const auto read = core::ReadMappings(
        {"text", "motiondb-marker-set 1\nextend standard34\n" + found->mapping_text}, standard);
    INFO(read.status());
    REQUIRE(read.ok());
    REQUIRE(read->size() == 1);
    CHECK(read->front().name == fitted->mappings.front().name);
    CheckSame(read->front().rules, fitted->mappings.front().rules);
  }
}

TEST_CASE("FindSourcePoints: markers of the first complete frame", "[core][inspection]") {
  core::MarkerMotion motion = StandardMarkers();
  motion.positions_m.row(0).segment(3, 3).setConstant(kMissing);
  motion.positions_m.row(1).segment(9, 3).setConstant(kMissing);
  const auto found = core::FindSourcePoints(core::StandardScheme(), motion);
  REQUIRE(found.ok());
  CHECK(found->mapping.empty());  // the markers' own names
  CHECK(found->mapping_text.empty());
  REQUIRE(found->points.size() == motion.names.size());
  for (std::size_t m = 0; m < motion.names.size(); ++m) {
    const core::SourcePoint& point = found->points[m];
    CHECK(point.parent == -1);
    CHECK(point.markers == std::vector<std::string>{motion.names[m]});
    for (int axis = 0; axis < 3; ++axis) {
      const auto column = static_cast<Eigen::Index>(3 * m) + axis;
      CHECK(point.position_m[axis] == motion.positions_m(2, column));
    }
  }
  // Without a complete frame, the first one with the most markers.
  for (Eigen::Index t = 0; t < motion.positions_m.rows(); ++t) {
    motion.positions_m.row(t).segment(t == 5 ? 9 : 3, t == 5 ? 3 : 9).setConstant(kMissing);
  }
  const auto partial = core::FindSourcePoints(core::StandardScheme(), motion);
  REQUIRE(partial.ok());
  CHECK(partial->points[0].position_m[0] == motion.positions_m(5, 0));
  CHECK(std::isnan(partial->points[3].position_m[0]));
}

TEST_CASE("FindSourcePoints: the error of a motion without a mapping", "[core][inspection]") {
  core::MarkerMotion motion = StandardMarkers();
  for (std::string& name : motion.names) name = "point " + name;
  motion.names.resize(3);
  motion.positions_m = core::FrameMatrix(motion.positions_m.leftCols(9));
  CHECK(absl::IsInvalidArgument(core::FindSourcePoints(core::StandardScheme(), motion).status()));
}

}  // namespace
}  // namespace motiondb::tests::source_points_test
