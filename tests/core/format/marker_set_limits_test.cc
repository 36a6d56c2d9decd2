// Marker-set files beyond the limits: each limit is reported with its line.
#include <fmt/format.h>

#include "core/format/marker_set_file.h"
#include "core/motion/marker_set.h"
#include "tests/core/format/reading.h"

namespace motiondb::tests::marker_set_limits_test {
namespace {

using Catch::Contains;

constexpr const char kHead[] = "motiondb-marker-set 1\nname n\nmarker lhip\nmarker rhip\n";

std::string RefusalOf(const std::string& text) {
  return ErrorMessageOf(core::ReadMarkerSetFile({"many.markers", text}));
}

std::string Points(std::size_t count) {
  std::string rule;
  for (std::size_t i = 0; i < count; ++i) {
    rule += fmt::format("{}{} p{}", i == 0 ? "" : " + ", i == 0 ? 1 : 0, i);
  }
  return rule;
}

TEST_CASE("Marker set: too many markers, mappings, legs and points are refused with their line",
          "[core][format][hostile]") {
  std::string text = kHead;
  for (std::size_t m = 2; m <= core::kMaxMarkers; ++m) text += fmt::format("marker m{}\n", m);
  CHECK_THAT(RefusalOf(text), Contains("many.markers:259: expected at most 256 markers"));

  text = kHead;
  for (std::size_t m = 0; m <= core::kMaxMappings; ++m) {
    text += fmt::format("mapping m{}\nlhip = a\nrhip = b\n", m);
  }
  CHECK_THAT(RefusalOf(text), Contains("expected at most 200 mappings"));

  text = std::string(kHead) + "marker knee\n";
  for (int leg = 0; leg < 3; ++leg) text += "leg lhip knee rhip\n";
  CHECK_THAT(RefusalOf(text), Contains("many.markers:8: expected at most two legs"));

  text = std::string(kHead) + "mapping m\nlhip = " + Points(core::kMaxRulePoints + 1) + "\n";
  CHECK_THAT(RefusalOf(text), Contains("'lhip' is made of more than 32 points"));
}

TEST_CASE("Marker set: nested rules have the same limit of points", "[core][format][hostile]") {
  // 20 points of 20 points each would be 400, in every mapping.
  std::string text = kHead;
  std::string middle = "middle = ";
  for (int i = 0; i < 20; ++i) {
    text += fmt::format("marker m{}\n", i);
    middle += fmt::format("{}{} m{}", i == 0 ? "" : " + ", i == 0 ? 1 : 0, i);
  }
  text += "marker middle\n" + middle + "\nmapping one\nlhip = a\nrhip = b\n";
  for (int i = 0; i < 20; ++i) text += fmt::format("m{} = {}\n", i, Points(20));
  CHECK_THAT(RefusalOf(text), Contains("'middle' is made of more than 32 points"));
}

// A `source` database stores the names of its first clip in such a file. If it could not be read
// back, the next start would lose it.
TEST_CASE("Marker set: names with quotes, signs and spaces are preserved",
          "[core][format][hostile]") {
  core::MarkerScheme scheme;
  scheme.set.name = "an \"odd\" set";
  scheme.set.markers = {"l\"hip", "\"", "\"\"", "a b", "#", "=", "1", "offset", "\xC3\xA4"};
  scheme.set.landmarks = {.left_hip = 0, .right_hip = 1, .legs = {}};
  const std::string text = core::WriteMarkerSetFile(scheme);
  const auto read = core::ReadMarkerSetFile({"odd.markers", text});
  INFO(MessageOf(read.status()));
  REQUIRE(read.ok());
  CHECK(read->set.markers == scheme.set.markers);
  CHECK(core::WriteMarkerSetFile(*read) == text);
}

}  // namespace
}  // namespace motiondb::tests::marker_set_limits_test
