// Files with mappings only, for a set that exists already.
#include <catch2/catch.hpp>

#include "core/format/marker_set_file.h"
#include "tests/core/format/reading.h"
#include "tests/core/format/same_scheme.h"

namespace motiondb::tests::mapping_file_test {
namespace {

using Catch::Contains;

const std::string kMagic = "motiondb-marker-set 1\n";

const std::string kSet =
    kMagic + "name mine\nmarker Left\nmarker Right\nmarker \"Top of head\"\nhips Left Right\n";
const std::string kDefault = "\"Top of head\" = 0.25 Left + 0.75 Right\n";

// Odd names, an offset, and a rule in place of the default one.
const std::string kRig =
    "mapping \"the rig\"\n"
    "signature \"l hip\" r.hip\n"
    "Left = \"l hip\"\n"
    "Right = 2 r.hip + -1 \"r\"\"out\" offset spine 0 0.1 -0.25\n"
    "\"Top of head\" = 0.1 \"3\" + 0.9 \"offset\"\n";
const std::string kSparse = "mapping sparse\nLeft = l\nRight = 3 r + -2 s\n";

core::MarkerScheme SchemeOf(const std::string& text) {
  auto scheme = core::ReadMarkerSetFile({"my.markers", text});
  INFO(scheme.status());
  REQUIRE(scheme.ok());
  return *std::move(scheme);
}

core::MarkerScheme Base() {
  return SchemeOf(kSet + kDefault + "mapping old\nLeft = a\nRight = b\n");
}

std::vector<core::MarkerMapping> MappingsOf(const std::string& text,
                                            const core::MarkerScheme& base) {
  auto mappings = core::ReadMappings({"my.mappings", text}, base);
  INFO(mappings.status());
  REQUIRE(mappings.ok());
  return *std::move(mappings);
}

}  // namespace

TEST_CASE("ReadMappings: equals the mappings of a whole file, with and without extend",
          "[core][format]") {
  const core::MarkerScheme whole = SchemeOf(kSet + kDefault + kRig + kSparse);
  for (const char* extend : {"", "extend mine\n", "# a comment\n\nextend \"mine\"\r\n"}) {
    CAPTURE(extend);
    const auto mappings = MappingsOf(kMagic + extend + kRig + kSparse, Base());
    REQUIRE(mappings.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) CheckSame(mappings[i], whole.mappings[i]);
  }
}

TEST_CASE("ReadMappings: uses the default rules of the set", "[core][format]") {
  const auto mappings = MappingsOf(kMagic + kSparse, Base());
  REQUIRE(mappings.size() == 1);
  CHECK(mappings[0].name == "sparse");
  CHECK(mappings[0].signature == std::vector<std::string>{"l", "r", "s"});
  REQUIRE(mappings[0].rules.size() == 3);
  const auto& points = mappings[0].rules[2].points;
  REQUIRE(points.size() == 3);
  CHECK(points[0].name == "l");
  CHECK(points[0].weight == 0.25);
  CHECK(points[1].name == "r");
  CHECK(points[1].weight == 2.25);
  CHECK(points[2].name == "s");
  CHECK(points[2].weight == -1.5);
  CHECK_THAT(ErrorMessageOf(core::ReadMappings({"my.mappings", kMagic + kSparse}, SchemeOf(kSet))),
             Contains("my.mappings") && Contains("'sparse' has no rule for marker 'Top of head'"));
}

TEST_CASE("ReadMappings: errors name file, line and what was expected", "[core][format]") {
  const auto error = [](const std::string& text) {
    return ErrorMessageOf(core::ReadMappings({"my.mappings", text}, Base()));
  };
  CHECK_THAT(error(""), Contains("my.mappings") && Contains("motiondb-marker-set 1"));
  CHECK_THAT(error("BVH\n"), Contains("my.mappings:1") && Contains("motiondb-marker-set 1"));
  CHECK_THAT(error(kMagic), Contains("my.mappings") && Contains("at least one 'mapping NAME'"));
  CHECK_THAT(error(kMagic + "extend mine\n"), Contains("at least one 'mapping NAME'"));
  for (const char* line : {"extend standard34\n", "extend other\n", "extend\n"}) {
    CHECK_THAT(error(kMagic + line + kRig), Contains("my.mappings:2") && Contains("extend mine"));
  }
  for (const char* line :
       {"name mine\n", "marker Nose\n", "hips Left Right\n", "leg Left Right Left\n", "fly\n"}) {
    CHECK_THAT(error(kMagic + line + kRig), Contains("my.mappings:2") &&
                                                Contains("expected only mappings") &&
                                                Contains("'mine'"));
    CHECK_THAT(error(kMagic + kRig + line),
               Contains("my.mappings:7") && Contains("expected only mappings"));
  }
  CHECK_THAT(error(kMagic + "Left = a\n" + kRig),
             Contains("my.mappings:2") && Contains("'mapping NAME' before its rules"));
  CHECK_THAT(error(kMagic + "signature a\n" + kRig),
             Contains("my.mappings:2") && Contains("before its signature"));
  CHECK_THAT(error(kMagic + "mapping m\nNose = a\n"),
             Contains("my.mappings:3") && Contains("'Nose'"));
  CHECK_THAT(error(kMagic + "mapping m\nLeft = a\nLeft = b\n"),
             Contains("my.mappings:4") && Contains("got a second"));
  CHECK_THAT(error(kMagic + "mapping m\nLeft = a\n"),
             Contains("my.mappings") && Contains("'m' has no rule for marker 'Right'"));
}

TEST_CASE("WriteMapping: ReadMappings reads the same mapping back", "[core][format]") {
  for (const core::MarkerScheme& scheme :
       {SchemeOf(kSet + kDefault + kRig + kSparse), core::StandardScheme()}) {
    for (const core::MarkerMapping& mapping : scheme.mappings) {
      CAPTURE(mapping.name);
      const auto back = MappingsOf(kMagic + core::WriteMapping(scheme.set, mapping), scheme);
      REQUIRE(back.size() == 1);
      CheckSame(back[0], mapping);
    }
  }
}

TEST_CASE("WriteMapping: the set and its mappings, one after the other, are a whole file",
          "[core][format]") {
  const core::MarkerScheme& scheme = core::StandardScheme();
  std::string text = core::WriteMarkerSetFile({scheme.set, scheme.default_rules, {}});
  for (const auto& mapping : scheme.mappings) text += core::WriteMapping(scheme.set, mapping);
  CheckSame(SchemeOf(text), scheme);
  CHECK(text == core::WriteMarkerSetFile(scheme));
}

TEST_CASE("MarkerSetFile: an extended set keeps the markers of its base", "[core][format]") {
  for (const char* const line :
       {"name mine", "marker Extra", "hips LHip RHip", "leg LHip LKnee LAnkle"}) {
    const auto extended =
        core::ReadMarkerSetFile({"my.markers", kMagic + "extend standard34\n" + line + "\n"});
    CHECK_THAT(std::string(extended.status().message()),
               Contains("my.markers:3") && Contains("only mappings and rules after 'extend"));
  }
}

TEST_CASE("MarkerSetFile: no more mappings than allowed, with those of the base",
          "[core][format]") {
  std::string text = kMagic + "extend standard34\n";
  const std::string rules =
      core::WriteMapping(core::StandardScheme().set, core::StandardScheme().mappings.front());
  for (std::size_t i = 0; i < core::kMaxMappings - 1; ++i) {
    text += "mapping m" + std::to_string(i) + rules.substr(rules.find('\n'));
  }
  const auto extended = core::ReadMarkerSetFile({"my.markers", text});
  CHECK_THAT(std::string(extended.status().message()), Contains("at most 200 mappings"));
}

TEST_CASE("MarkerSetFile: weights within the tolerance stay within it when they are combined",
          "[core][format]") {
  const std::string file = kSet +
                           "\"Top of head\" = 3 Left + -2 Right\n"
                           "mapping odd\nLeft = 0.5 a + 0.5000009 b\nRight = 0.9999991 c\n";
  const core::MarkerScheme scheme = SchemeOf(file);
  const std::string text = core::WriteMarkerSetFile(scheme);
  CHECK(core::WriteMarkerSetFile(SchemeOf(text)) == text);
}

}  // namespace motiondb::tests::mapping_file_test
