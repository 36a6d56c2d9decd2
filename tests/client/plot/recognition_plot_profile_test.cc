#include "client/cli/plot/recognition_plot_profile.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "client/cli/plot/picture.h"
#include "tests/client/plot/recognition_answers.h"
#include "tests/client/plot/svg_elements.h"

namespace motiondb::tests::recognition_plot_profile_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string ProfileSvg(const v1::RecognizeRequest& request,
                       const std::vector<v1::RecognizeResponse>& layers) {
  return SvgOf(ProfilePicture(request, layers));
}

TEST_CASE("ProfilePlot: a line for each clip and layer, a strip of winners", "[client][cli]") {
  const std::vector<v1::RecognizeResponse> layers = {WalkThenJog(12), WalkThenJog(6),
                                                     WalkThenJog(3)};
  const std::string svg = ProfileSvg(RecognizeWalks(), layers);
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c0"] == 3);  // jog
  CHECK(elements["path.clip best c1"] == 3);  // walk
  CHECK(elements["path.clip c1"] == 3);
  CHECK(elements["rect.winner a0"] == 3);
  CHECK(elements["rect.winner a1"] == 3);
  CHECK(elements["text.winner-name t1"] == 3);
  CHECK_THAT(svg, Contains("Generation probability: 07_06.amc in walks") &&
                      Contains(">10 windows of 0.4 s, every 0.1 s; 3 stored clips of 2 labels; ") &&
                      Contains("Layer 12, the bottom of the tree<") && Contains(">Layer 6<") &&
                      Contains(">Layer 3<"));
  CHECK_THAT(svg, Contains(">walk: 2 clips<") && Contains(">jog: 1 clip<"));
  CHECK_THAT(svg, Contains("<title>walk, 0.15-0.65 s</title>") &&
                      Contains("<title>jog, 0.65-1.15 s</title>") &&
                      Contains("<title>clip-002 (jog)</title>"));
  CHECK_THAT(svg, Contains(">-1000<") && Contains("middle of the window (s)"));
  CHECK_THAT(svg, !Contains("nan") && !Contains("inf") && !Contains("-0.00"));
  CHECK(svg == ProfileSvg(RecognizeWalks(), layers));

  v1::RecognizeRequest one_layer = RecognizeWalks();
  one_layer.set_layer(6);
  one_layer.set_generation(v1::GENERATION_TOP_PATHS);
  one_layer.set_path_count(5);
  CHECK_THAT(ProfileSvg(one_layer, {WalkThenJog(6)}),
             !Contains("bottom of the tree") && Contains("best 5 paths"));
}

TEST_CASE("ProfilePlot: chosen layers", "[client][cli]") {
  CHECK(PlottedLayers(16) == std::vector<int>{8, 4});
  CHECK(PlottedLayers(15) == std::vector<int>{8, 3});
  CHECK(PlottedLayers(5) == std::vector<int>{3, 2});
  CHECK(PlottedLayers(4) == std::vector<int>{2});
  CHECK(PlottedLayers(3) == std::vector<int>{2});
  CHECK(PlottedLayers(2).empty());
  CHECK(PlottedLayers(1).empty());
  CHECK(PlottedLayers(0).empty());
}

TEST_CASE("ProfilePlot: one window is a dash as wide as the window", "[client][cli]") {
  const std::string svg = ProfileSvg(RecognizeWalks(), {WalkThenJog(12, 1)});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip c1"] + elements["path.clip best c1"] == 2);
  CHECK(elements["rect.winner a1"] == 1);
  CHECK_THAT(svg,
             Contains("one window of 0.4 s") && Contains("d=\"M80.00 ") && Contains("H934.00"));
}

TEST_CASE("ProfilePlot: no windows, no answer, no clips", "[client][cli]") {
  for (const auto& layers : {std::vector<v1::RecognizeResponse>{},
                             std::vector<v1::RecognizeResponse>{v1::RecognizeResponse()}}) {
    const std::string svg = ProfileSvg(RecognizeWalks(), layers);
    CHECK(ElementsInGroups(svg).empty());
    CHECK(Count(svg, ">no windows<") == 1);
  }
  const std::string svg =
      ProfileSvg(RecognizeWalks(), {Answer(3, 4, {}, [](int, int) { return 0.0; })});
  CHECK(ElementsInGroups(svg).empty());
  CHECK_THAT(svg, Contains(">no clips<"));
}

TEST_CASE("ProfilePlot: values that are not finite are omitted and counted", "[client][cli]") {
  // Clip 0 has a gap, clip 1 has only window 4, clip 2 has no value.
  const auto layer = Answer(9, 8, {"walk", "walk", "jog"}, [](int clip, int window) {
    if (clip == 0) return window == 2 ? -kInfinity : window == 3 ? std::nan("") : -5.0 - window;
    return clip == 1 && window == 4 ? -70.0 : clip == 1 ? kInfinity : -kInfinity;
  });
  const std::string svg = ProfileSvg(RecognizeWalks(), {layer});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c1"] == 1);
  CHECK(elements["path.clip c1"] == 1);
  CHECK(elements.count("path.clip c0") == 0);
  CHECK_THAT(svg, Contains("17 of 24 values are -Infinity: no path"));
  CHECK_THAT(svg, !Contains("nan") && !Contains("\"inf") && !Contains(" inf"));
  const LayerProfile profile = LayerProfileFrom(layer);
  CHECK(!profile.winners[2]);
  CHECK(profile.winners[4] == "walk");

  const std::string nothing = ProfileSvg(
      RecognizeWalks(), {Answer(9, 8, {"walk", "jog"}, [](int, int) { return -kInfinity; })});
  CHECK(ElementsInGroups(nothing).empty());
  CHECK_THAT(nothing, Contains(">no clip explains any window<") &&
                          Contains("16 of 16 values are -Infinity"));
}

TEST_CASE("ProfilePlot: values below the axis are clipped and counted", "[client][cli]") {
  const std::string svg =
      ProfileSvg(RecognizeWalks(), {Answer(9, 4, {"walk", "jog"}, [](int clip, int window) {
                   return clip == 0 ? -2.0 : window == 1 ? -1e300 : -2e6;
                 })});
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("4 of 8 lie below<") && Contains(">-1e6<"));
  CHECK(svg.size() < 20000);
}

TEST_CASE("ProfilePlot: windows with invalid times are omitted", "[client][cli]") {
  v1::RecognizeResponse layer = WalkThenJog(9);
  layer.mutable_windows(1)->set_start_seconds(std::nan(""));
  layer.mutable_windows(2)->set_end_seconds(kInfinity);
  layer.mutable_windows(3)->set_end_seconds(-1);
  layer.mutable_windows(4)->set_end_seconds(1e300);
  CHECK(LayerProfileFrom(layer).windows.size() == 6);
  ElementsInGroups(ProfileSvg(RecognizeWalks(), {layer}));
}

TEST_CASE("ProfilePlot: names are escaped and shortened", "[client][cli]") {
  const std::string label = "<kick> & \"punch\"";
  v1::RecognizeRequest request = RecognizeWalks();
  request.mutable_observation()->mutable_file()->set_file_name(std::string(300, 'f') + "<&>.bvh");
  const std::string svg = ProfileSvg(
      request, {Answer(9, 20, {label, std::string(500, 'x'), ""},
                       [](int clip, int window) { return -1.0 - (clip + window) % 3; })});
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("&lt;kick&gt; &amp; &quot;punch&quot;: 1 clip<") &&
                      Contains("(no label): 1 clip<") && Contains("xxx...: 1 clip<") &&
                      Contains("fff... in walks<"));
}

TEST_CASE("ProfilePlot: of hundreds of clips the best are lines, the others a band",
          "[client][cli]") {
  std::vector<std::string> labels;
  for (int i = 0; i < 300; ++i) labels.push_back(fmt::format("label {:03}", i));
  const auto layer = Answer(9, 6, labels, [](int clip, int window) {
    return clip == 290 - window % 2 ? -1.0 : -50.0 - clip;
  });
  const std::string svg = ProfileSvg(RecognizeWalks(), {layer});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c0"] == 1);
  CHECK(elements["path.clip best c1"] == 1);
  CHECK(elements["path.clip c2"] == 1);
  CHECK(elements["path.clip c3"] == 1);
  CHECK(elements["path.band"] == 1);
  CHECK(Count(svg, "<path ") == 5);
  CHECK(Count(svg, "class=\"sample ") == 4);
  CHECK_THAT(svg, Contains(">5 % to 95 % of 296 other clips<") && Contains("300 stored clips"));
  // Winning labels come first, then those of lines, so that their colours differ.
  const auto ranked = ProfileLabels({LayerProfileFrom(layer)});
  CHECK(ranked[0].name == "label 289");
  CHECK(ranked[1].name == "label 290");
  CHECK(ranked[2].name == "label 000");
  CHECK(ranked[3].name == "label 001");
}

TEST_CASE("ProfilePlot: up to 24 clips are lines", "[client][cli]") {
  for (const int clips : {24, 25}) {
    const auto layer = Answer(9, 6, std::vector<std::string>(clips, "walk"),
                              [](int clip, int) { return -10.0 * (clip + 1); });
    auto elements = ElementsInGroups(ProfileSvg(RecognizeWalks(), {layer}));
    CHECK(elements["path.clip best c0"] == 1);
    CHECK(elements["path.clip c0"] == (clips == 24 ? 23 : 2));
    CHECK(elements["path.band"] == (clips == 24 ? 0 : 1));
  }
}

TEST_CASE("ProfilePlot: the numbers of lines and of labels in the legend are limited",
          "[client][cli]") {
  std::vector<std::string> labels;
  for (int i = 0; i < 200; ++i) labels.push_back(fmt::format("label {:03}", i));
  // In each window of a layer another clip is the best; the first ones are it twice.
  const auto layer = [&](int number) {
    return Answer(number, 30, labels, [&](int clip, int window) {
      return clip == 100 * (number % 2) + window % 25 ? -1.0 : -50.0 - clip;
    });
  };
  const std::string svg = ProfileSvg(RecognizeWalks(), {layer(9), layer(8)});
  auto elements = ElementsInGroups(svg);
  int lines = 0;
  for (const auto& [element, count] : elements) lines += element.starts_with("path.clip") * count;
  CHECK(lines == 2 * 20);
  CHECK(elements["path.clip best c3"] + elements["path.clip best c3 d1"] +
            elements["path.clip best c3 d2"] ==
        5);
  CHECK(elements["path.band"] == 2);
  CHECK(Count(svg, "class=\"sample ") == 24);
  CHECK_THAT(svg, Contains(">and 26 more<") && Contains(">5 % to 95 % of 180 other clips<"));
}

TEST_CASE("ProfilePlot: the band has the quantiles of the other clips", "[client][cli]") {
  // Of 103 clips, the first three are lines; clip 3 + i of the band has -100 - i in window 0, and
  // -Infinity in window 2. Window 3 has only one value of the band.
  const auto layer = Answer(9, 4, std::vector<std::string>(103, "walk"), [](int clip, int window) {
    if (clip < 3) return -1.0 - clip;
    if (window == 2 || (window == 3 && clip != 50)) return -kInfinity;
    return -97.0 - clip;
  });
  const std::string svg = ProfileSvg(RecognizeWalks(), {layer});
  ElementsInGroups(svg);
  const auto at = svg.find("<path class=\"band\" d=\"");
  REQUIRE(at != std::string::npos);
  const std::string data = svg.substr(at, svg.find("/>", at) - at);
  CHECK(Count(data, "M") == 2);  // a gap in window 2
  CHECK(Count(data, "Z") == 2);
  LogProbabilityAxis axis;
  for (const double value : {-1.0, -199.0}) axis.Add(value);
  const auto y = [&](double value) {
    return SvgNumber(HeadingHeight(2) + 24 + 176 * axis.Fraction(value));
  };
  CHECK_THAT(data, Contains(" " + y(-104) + "H") && Contains("V" + y(-195) + "H") &&
                       Contains(" " + y(-147) + "H"));
  CHECK_THAT(data, !Contains(y(-100)) && !Contains(y(-199)));
}

TEST_CASE("ProfilePlot: the size for a long motion is limited by the pixels", "[client][cli]") {
  const auto layer = Answer(9, 20000, {"walk"}, [](int, int window) {
    return window == 7000 ? -900.0 : -5.0 - window % 7;
  });
  const std::string svg = ProfileSvg(RecognizeWalks(), {layer});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c0"] == 1);
  CHECK(elements["rect.winner a0"] == 1);
  CHECK(svg.size() < 60000);
  CHECK(svg == ProfileSvg(RecognizeWalks(), {layer}));
}

TEST_CASE("ProfilePlot: a winner is named if its name fits", "[client][cli]") {
  const auto layer = Answer(9, 400, {"walk", "jog"}, [](int clip, int window) {
    return clip == 1 && (window % 2 == 0 || window < 100) ? -1.0 : -2.0 - clip;
  });
  auto elements = ElementsInGroups(ProfileSvg(RecognizeWalks(), {layer}));
  CHECK(elements["rect.winner a0"] == 150);
  CHECK(elements["rect.winner a1"] == 150);
  CHECK(elements["text.winner-name t0"] == 1);
  CHECK(elements.count("text.winner-name t1") == 0);
}

TEST_CASE("LogProbabilityAxis: positions are monotonic for all values", "[client][cli]") {
  LogProbabilityAxis axis;
  CHECK(axis.Ticks(0.1) == std::vector<double>{0, -1, -10});
  for (const double value : {-3.0, -47000.0, -kInfinity, std::nan("")}) axis.Add(value);
  CHECK(axis.Ticks(0.1) == std::vector<double>{0, -10, -100, -1000, -10000});
  double above = 0;
  for (const double value : {0.0, -0.5, -3.0, -10.0, -11.0, -1000.0, -47000.0}) {
    CHECK(axis.Fraction(value) > above);
    above = axis.Fraction(value);
  }
  CHECK(above < 1);
  CHECK(!axis.IsBelow(-47000));
  axis.Add(-1e300);
  axis.Add(120);
  CHECK(axis.IsBelow(-1e300));
  CHECK(axis.Fraction(120) > 0);
  CHECK(axis.Fraction(-1e6) < 1);
  CHECK(axis.Ticks(0.05).front() == 100);
  CHECK(LogProbabilityAxis::TickText(0) == "0");
  CHECK(LogProbabilityAxis::TickText(-10000) == "-10000");
  CHECK(LogProbabilityAxis::TickText(-1e5) == "-1e5");
}

}  // namespace
}  // namespace motiondb::tests::recognition_plot_profile_test
