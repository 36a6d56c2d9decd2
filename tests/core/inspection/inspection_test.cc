#include "core/inspection/inspection.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/format/marker_set_file.h"
#include "tests/support/humanoid_bvh.h"

namespace motiondb::tests::inspection_test {
namespace {

core::Inspection Inspect(const std::string& bvh, const core::ReadOptions& given = {},
                         std::optional<double> leg_length_m = std::nullopt) {
  const auto file = core::ReadMotionFile(core::FileFormat::kBvh, {"a.bvh", bvh}, {}, given);
  INFO(file.status());
  REQUIRE(file.ok());
  return core::InspectMotion("a.bvh", *file, leg_length_m);
}

const core::InspectedPoint& PointNamed(const core::Inspection& inspection,
                                       const std::string& name) {
  const auto found = std::ranges::find(inspection.points, name, &core::InspectedPoint::name);
  REQUIRE(found != inspection.points.end());
  return *found;
}

TEST_CASE("InspectMotion: finds body parts, conventions and sizes", "[core][inspection]") {
  const core::Inspection inspection = Inspect(HumanoidBvh(100, 60));
  CHECK(inspection.problems.empty());
  CHECK(inspection.has_hierarchy);
  CHECK(inspection.frame_count == 60);
  CHECK(inspection.frame_rate_hz == Approx(30).margin(0.01));
  CHECK(inspection.report.metres_per_unit == 0.01);
  CHECK(inspection.leg_length_m.value() == Approx(0.82).margin(0.005));
  CHECK(inspection.stature_m.value() == Approx(1.7).margin(0.15));
  CHECK(PointNamed(inspection, "LeftLeg").role == "left knee");
  CHECK(PointNamed(inspection, "LeftLeg").confidence > 0.8);
  CHECK(PointNamed(inspection, "RightForeArm").role == "right elbow");
  CHECK(inspection.points[PointNamed(inspection, "LeftLeg").parent].name == "LeftUpLeg");
  CHECK(PointNamed(inspection, "Hips").position_m[2] == Approx(0.93).margin(0.01));
}

TEST_CASE("InspectMotion: the mapping file is one that a database accepts", "[core][inspection]") {
  const core::Inspection inspection = Inspect(HumanoidBvh(100, 60));
  const auto mappings =
      core::ReadMappings({"mapping", inspection.mapping_file}, core::StandardScheme());
  INFO(inspection.mapping_file);
  INFO(mappings.status());
  REQUIRE(mappings.ok());
  CHECK(mappings->size() == 1);
}

TEST_CASE("InspectMotion: problems of a file that ingest would reject", "[core][inspection]") {
  SECTION("a wrong unit") {
    const auto inspection = Inspect(HumanoidBvh(100, 60), {.metres_per_unit = 1});
    REQUIRE(inspection.problems.size() == 1);
    CHECK_THAT(inspection.problems[0], Catch::Contains("--metres-per-unit 0.01"));
  }
  SECTION("a wrong up axis") {
    const auto inspection = Inspect(HumanoidBvh(100, 60), {.up_axis = core::UpAxis::kZ});
    REQUIRE(inspection.problems.size() == 1);
    CHECK_THAT(inspection.problems[0], Catch::Contains("--up-axis y"));
  }
  SECTION("options are suggested by themselves, not in texts of the file") {
    const auto inspection = Inspect(HumanoidBvh(100, 60), {.metres_per_unit = 1});
    CHECK(inspection.suggested_options == std::vector<std::string>{"--metres-per-unit 0.01"});
  }
  SECTION("no person: a draft of a mapping names what was found") {
    std::string bvh = HumanoidBvh(100, 20);
    for (const char* hand : {"LeftHand", "RightHand", "LeftForeArm", "RightForeArm"}) {
      const std::size_t at = bvh.find(fmt::format("JOINT {}\n", hand));
      bvh.replace(at, std::string("JOINT ").size() + std::string(hand).size(),
                  fmt::format("JOINT Prop{}", at));
    }
    const auto inspection = Inspect(bvh, {.metres_per_unit = 0.01, .up_axis = core::UpAxis::kY});
    REQUIRE(inspection.problems.size() == 1);
    CHECK_THAT(inspection.problems[0], Catch::Contains("uncertain: left elbow ('Prop"));
    CHECK_THAT(inspection.mapping_file,
               Catch::Contains("mapping a\n") && Catch::Contains("LKnee = LeftLeg  # confidence"));
  }
  SECTION("a given leg length and a frame rate that ingest refuses") {
    const std::string bvh = HumanoidBvh(100, 20);
    const core::Inspection inspection = Inspect(bvh, {}, 85);
    REQUIRE(!inspection.problems.empty());
    CHECK_THAT(inspection.problems[0], Catch::Contains("85 cm are 0.85 m"));
    std::string slow = bvh;
    slow.replace(slow.find("0.0333333"), 9, "5");
    const auto problems = Inspect(slow).problems;
    REQUIRE(problems.size() == 1);
    CHECK_THAT(problems[0], Catch::Contains("at least 1.875 Hz"));
  }
}

TEST_CASE("FootSlide: zero for a fixed foot, the speed of a sliding one", "[core][inspection]") {
  core::MarkerMotion motion;
  motion.names = core::StandardScheme().set.markers;
  motion.frame_rate_hz = 50;
  motion.positions_m = core::FrameMatrix::Zero(100, 3 * 34);
  CHECK(core::FootSlide(motion, 0.85).value() == 0);
  for (int t = 0; t < 100; ++t) {
    for (int m = 0; m < 34; ++m) motion.positions_m(t, 3 * m) = 0.01F * static_cast<float>(t);
  }
  CHECK(core::FootSlide(motion, 0.85).value() == Approx(0.5).margin(1e-3));
  motion.positions_m.setConstant(std::nanf(""));
  CHECK(!core::FootSlide(motion, 0.85));
  CHECK(!core::Stature(motion, 0.85));
}

}  // namespace

namespace {

TEST_CASE("DraftMapping: rules of what was found, comments for the rest", "[core][inspection]") {
  core::PointCloud points;
  points.names = {"pole", "left \"knee\""};
  points.parents = {-1, 0};
  points.frames.emplace_back(Eigen::Matrix3Xd::Zero(3, 2));
  const std::string draft = core::DraftMapping(core::StandardScheme().set, points, "my rig");
  CHECK_THAT(draft, Catch::StartsWith("# A draft") && Catch::Contains("\nmapping \"my rig\"\n") &&
                        Catch::Contains("# LWrist = ?\n"));
  // Without rules it is a file in the right format that says what is missing.
  const auto read =
      core::ReadMappings({"draft", "motiondb-marker-set 1\n" + draft}, core::StandardScheme());
  CHECK_THAT(std::string(read.status().message()),
             Catch::Contains("no rule for marker") || Catch::Contains("expected a rule"));
}

}  // namespace

}  // namespace motiondb::tests::inspection_test
