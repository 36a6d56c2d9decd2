#include "core/format/marker_set_file.h"

#include <catch2/catch.hpp>

#include "tests/core/format/same_scheme.h"

namespace motiondb::tests::marker_set_file_test {
namespace {

const std::string kGood =
    "motiondb-marker-set 1\n"
    "# two hips and a \"head\"\n"
    "name mine\n"
    "marker Left\r\n"
    "marker Right\r"
    "marker \"Top of head\"\n"
    "hips Left Right\n"
    "\"Top of head\" = 0.5 Left + 0.5 Right\n"
    "mapping rig\n"
    "Left = l.hip\n"
    "Right = 2 r.hip + -1 r.out offset spine 0 0.1 -2.5e-1\n"
    "\"Top of head\" = \"3\"\n";

std::string ErrorOf(const std::string& text) {
  const auto scheme = core::ReadMarkerSetFile({"my.markers", text});
  REQUIRE_FALSE(scheme.ok());
  CHECK(scheme.status().code() == absl::StatusCode::kInvalidArgument);
  return std::string(scheme.status().message());
}

}  // namespace

TEST_CASE("MarkerSetFile: names, hips, rules, quotes, comments, any line end", "[core][format]") {
  const auto scheme = core::ReadMarkerSetFile({"my.markers", kGood});
  INFO(scheme.status());
  REQUIRE(scheme.ok());
  CHECK(scheme->set.name == "mine");
  CHECK(scheme->set.markers == std::vector<std::string>{"Left", "Right", "Top of head"});
  CHECK(scheme->set.landmarks.right_hip == 1);
  REQUIRE(scheme->mappings.size() == 1);
  const core::MarkerMapping& rig = scheme->mappings[0];
  CHECK(rig.signature == std::vector<std::string>{"3", "l.hip", "r.hip", "r.out"});
  CHECK(rig.rules[1].points[1].weight == -1);
  CHECK(rig.rules[1].offset_joint == "spine");
  CHECK(rig.rules[1].offset == Eigen::Vector3d(0, 0.1, -0.25));
  CHECK(rig.rules[2].points[0].name == "3");
  REQUIRE(scheme->default_rules.size() == 3);
  CHECK(scheme->default_rules[0].points.empty());
  CHECK(scheme->default_rules[1].points.empty());
  REQUIRE(scheme->default_rules[2].points.size() == 2);
  CHECK(scheme->default_rules[2].points[1].name == "Right");
  CHECK(scheme->default_rules[2].points[1].weight == 0.5);
}

TEST_CASE("MarkerSetFile: a default rule uses the mapping's own rules", "[core][format]") {
  std::string text = kGood.substr(0, kGood.find("Right = 2"));
  text += "Right = 3 r + -2 s\n";
  const auto scheme = core::ReadMarkerSetFile({"my.markers", text});
  INFO(scheme.status());
  REQUIRE(scheme.ok());
  const auto& points = scheme->mappings[0].rules[2].points;
  REQUIRE(points.size() == 3);
  CHECK(points[0].name == "l.hip");
  CHECK(points[0].weight == 0.5);
  CHECK(points[1].weight == 1.5);
  CHECK(points[2].weight == -1);
}

TEST_CASE("MarkerSetFile: writing and reading preserves the scheme", "[core][format]") {
  const core::MarkerScheme standard = core::StandardScheme();
  CHECK(standard.default_rules.size() == standard.set.markers.size());
  for (const core::MarkerScheme& scheme :
       {standard, core::MarkerScheme{standard.set, standard.default_rules, {}},
        core::MarkerScheme{standard.set, {}, {}},
        *core::ReadMarkerSetFile({"my.markers", kGood})}) {
    const std::string text = core::WriteMarkerSetFile(scheme);
    const auto back = core::ReadMarkerSetFile({"written", text});
    INFO(back.status());
    REQUIRE(back.ok());
    CheckSame(scheme, *back);
    CHECK(core::WriteMarkerSetFile(*back) == text);
  }
}

TEST_CASE("MarkerSetFile: a file can extend the standard set by a mapping", "[core][format]") {
  std::string text = "motiondb-marker-set 1\nextend standard34\nmapping mine\n";
  for (const std::string& marker : core::StandardScheme().set.markers) {
    // The default rules of the standard set give the others.
    const bool has_default = marker == "Pelvis" || marker.ends_with("Thigh") ||
                             marker.ends_with("Shin") || marker.ends_with("Heel") ||
                             marker.ends_with("Clavicle") || marker.ends_with("Arm") ||
                             marker.ends_with("Forearm");
    if (!has_default) text += marker + " = my_" + marker + "\n";
  }
  const auto extended = core::ReadMarkerSetFile({"mine.txt", text});
  INFO(extended.status());
  REQUIRE(extended.ok());
  const core::MarkerScheme& base = core::StandardScheme();
  CHECK(extended->set.name == base.set.name);
  CHECK(extended->set.markers == base.set.markers);
  CHECK(extended->set.landmarks.legs == base.set.landmarks.legs);
  REQUIRE(extended->mappings.size() == base.mappings.size() + 1);
  CHECK(extended->mappings.front().name == "mine");
  CHECK(extended->mappings.front().rules[0].points.front().name == "my_LHip");
  CHECK(extended->mappings.back().name == base.mappings.back().name);
  CHECK_THAT(ErrorOf("motiondb-marker-set 1\nextend other\n"),
             Catch::Contains("my.markers:2") && Catch::Contains("extend standard34"));
  CHECK_THAT(ErrorOf("motiondb-marker-set 1\nname n\nextend standard34\n"),
             Catch::Contains("instead of a name"));
}

TEST_CASE("MarkerSetFile: the standard set has 34 markers and whole legs", "[core][format]") {
  const core::MarkerScheme& scheme = core::StandardScheme();
  CHECK(scheme.set.marker_count() == 34);
  CHECK(scheme.set.dimension_count() == 204);
  CHECK(scheme.set.landmarks.legs.size() == 2);
  CHECK(scheme.mappings.size() >= 6);
}

TEST_CASE("MarkerSetFile: errors name file, line and what was expected", "[core][format]") {
  using Catch::Matchers::Contains;
  const std::string head = "motiondb-marker-set 1\nname n\nmarker A\nmarker B\nhips A B\n";
  CHECK_THAT(ErrorOf(""), Contains("my.markers") && Contains("motiondb-marker-set 1"));
  CHECK_THAT(ErrorOf("BVH\n"), Contains("my.markers:1"));
  CHECK_THAT(ErrorOf("motiondb-marker-set 2\n"), Contains("my.markers:1"));
  CHECK_THAT(ErrorOf(head + "marker A\n"), Contains("my.markers:6") && Contains("twice"));
  CHECK_THAT(ErrorOf(head + "hips A C\n"), Contains("my.markers:6") && Contains("'C'"));
  CHECK_THAT(ErrorOf(head + "hips A A\n"), Contains("two markers"));
  CHECK_THAT(ErrorOf(head + "leg A B\n"), Contains("leg HIP KNEE ANKLE"));
  CHECK_THAT(ErrorOf(head + "fly\n"), Contains("'fly'"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = x\n"), Contains("no rule for marker 'B'"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA =\n"), Contains("my.markers:7"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = 0.5 x\n"), Contains("sum to 1"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = 0.5\n"), Contains("after the weight"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = x offset j 1 2\n"), Contains("offset JOINT X Y Z"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = x offset j 1 2 z\n"), Contains("'z'"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = x y\n"), Contains("'y'"));
  CHECK_THAT(ErrorOf(head + "mapping m\nA = x\nA = y\n"), Contains("got a second"));
  CHECK_THAT(ErrorOf(head + "marker \"C\n"), Contains("closing quote"));
  CHECK_THAT(ErrorOf(head + "mapping m\nmarker C\n"), Contains("before the first mapping"));
  CHECK_THAT(ErrorOf("motiondb-marker-set 1\nname n\nmarker A\n"), Contains("hips LEFT RIGHT"));
  CHECK_THAT(ErrorOf("motiondb-marker-set 1\nmarker LHip\nmarker RHip\n"), Contains("name NAME"));
}

TEST_CASE("MarkerSetFile: no truncation crashes", "[core][format]") {
  const std::string text = core::WriteMarkerSetFile(core::StandardScheme());
  for (std::size_t length = 0; length < kGood.size(); ++length) {
    (void)core::ReadMarkerSetFile({"cut", std::string_view(kGood).substr(0, length)});
  }
  for (std::size_t length = 0; length < text.size(); length += 97) {
    (void)core::ReadMarkerSetFile({"cut", std::string_view(text).substr(0, length)});
  }
}

}  // namespace motiondb::tests::marker_set_file_test
