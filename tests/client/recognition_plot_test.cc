#include "client/cli/recognition_plot.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "client/cli/picture.h"
#include "tests/client/fake_server.h"
#include "tests/client/run_motiondb.h"
#include "tests/client/svg_elements.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/real_data.h"

namespace motiondb::tests::recognition_plot_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;
using Catch::EndsWith;
using Catch::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Windows of 0.4 s every 0.1 s. `log_probability(clip, window)` is the score of a clip.
template <typename LogProbability>
v1::RecognizeResponse Answer(int layer, int windows, const std::vector<std::string>& clip_labels,
                             const LogProbability& log_probability) {
  v1::RecognizeResponse response;
  for (int w = 0; w < windows; ++w) {
    v1::RecognitionWindow& window = *response.add_windows();
    window.set_start_seconds(0.1 * w);
    window.set_end_seconds(0.1 * w + 0.4);
    window.set_layer(layer);
    double best = -kInfinity;
    for (int c = 0; c < static_cast<int>(clip_labels.size()); ++c) {
      v1::ClipProbability& clip = *window.add_clips();
      clip.set_clip(fmt::format("databases/walks/clips/clip-{:03}", c));
      clip.set_label(clip_labels[c]);
      clip.set_log_probability(log_probability(c, w));
      if (window.labels_size() == 0) window.add_labels()->set_label(clip_labels[c]);
      if (!(clip.log_probability() > best)) continue;
      best = clip.log_probability();
      window.mutable_labels(0)->set_label(clip_labels[c]);
    }
  }
  return response;
}

v1::RecognizeRequest Request() {
  v1::RecognizeRequest request;
  request.set_database("databases/walks");
  request.mutable_observation()->mutable_file()->set_file_name("07_06.amc");
  return request;
}

// Clips 0 and 1 are walk, clip 2 is jog. The observation is jog from window 5.
v1::RecognizeResponse WalkThenJog(int layer, int windows = 10) {
  return Answer(layer, windows, {"walk", "walk", "jog"}, [](int clip, int window) {
    return (clip == 2) == (window >= 5) ? -3.0 - clip : -1000.0 * (clip + 1);
  });
}

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_CASE("RecognitionPlot: a line for each clip and layer, a strip of winners", "[client][cli]") {
  const std::vector<v1::RecognizeResponse> layers = {WalkThenJog(12), WalkThenJog(6),
                                                     WalkThenJog(3)};
  const std::string svg = RecognitionPlotSvg(Request(), layers);
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
  CHECK(svg == RecognitionPlotSvg(Request(), layers));

  v1::RecognizeRequest one_layer = Request();
  one_layer.set_layer(6);
  one_layer.set_generation(v1::GENERATION_TOP_PATHS);
  one_layer.set_path_count(5);
  CHECK_THAT(RecognitionPlotSvg(one_layer, {WalkThenJog(6)}),
             !Contains("bottom of the tree") && Contains("best 5 paths"));
}

TEST_CASE("RecognitionPlot: chosen layers", "[client][cli]") {
  CHECK(PlottedLayers(16) == std::vector<int>{8, 4});
  CHECK(PlottedLayers(15) == std::vector<int>{8, 3});
  CHECK(PlottedLayers(5) == std::vector<int>{3, 2});
  CHECK(PlottedLayers(4) == std::vector<int>{2});
  CHECK(PlottedLayers(3) == std::vector<int>{2});
  CHECK(PlottedLayers(2).empty());
  CHECK(PlottedLayers(1).empty());
  CHECK(PlottedLayers(0).empty());
}

TEST_CASE("RecognitionPlot: one window is a dash as wide as the window", "[client][cli]") {
  const std::string svg = RecognitionPlotSvg(Request(), {WalkThenJog(12, 1)});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip c1"] + elements["path.clip best c1"] == 2);
  CHECK(elements["rect.winner a1"] == 1);
  CHECK_THAT(svg,
             Contains("one window of 0.4 s") && Contains("d=\"M80.00 ") && Contains("L934.00 "));
}

TEST_CASE("RecognitionPlot: no windows, no answer, no clips", "[client][cli]") {
  for (const auto& layers : {std::vector<v1::RecognizeResponse>{},
                             std::vector<v1::RecognizeResponse>{v1::RecognizeResponse()}}) {
    const std::string svg = RecognitionPlotSvg(Request(), layers);
    CHECK(ElementsInGroups(svg).empty());
    CHECK(Count(svg, ">no windows<") == 1);
  }
  const std::string svg =
      RecognitionPlotSvg(Request(), {Answer(3, 4, {}, [](int, int) { return 0.0; })});
  CHECK(ElementsInGroups(svg).empty());
  CHECK_THAT(svg, Contains(">no clips<"));
}

TEST_CASE("RecognitionPlot: values that are not finite are omitted and counted", "[client][cli]") {
  // Clip 0 has a gap, clip 1 has only window 4, clip 2 has no value.
  const auto layer = Answer(9, 8, {"walk", "walk", "jog"}, [](int clip, int window) {
    if (clip == 0) return window == 2 ? -kInfinity : window == 3 ? std::nan("") : -5.0 - window;
    return clip == 1 && window == 4 ? -70.0 : clip == 1 ? kInfinity : -kInfinity;
  });
  const std::string svg = RecognitionPlotSvg(Request(), {layer});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c1"] == 1);
  CHECK(elements["path.clip c1"] == 1);
  CHECK(elements.count("path.clip c0") == 0);
  CHECK_THAT(svg, Contains("17 of 24 values are -Infinity: no path"));
  CHECK_THAT(svg, !Contains("nan") && !Contains("\"inf") && !Contains(" inf"));
  const LayerProfile profile = LayerProfileFrom(layer);
  CHECK(!profile.winners[2]);
  CHECK(profile.winners[4] == "walk");

  const std::string nothing = RecognitionPlotSvg(
      Request(), {Answer(9, 8, {"walk", "jog"}, [](int, int) { return -kInfinity; })});
  CHECK(ElementsInGroups(nothing).empty());
  CHECK_THAT(nothing, Contains(">no clip explains any window<") &&
                          Contains("16 of 16 values are -Infinity"));
}

TEST_CASE("RecognitionPlot: values below the axis are clipped and counted", "[client][cli]") {
  const std::string svg =
      RecognitionPlotSvg(Request(), {Answer(9, 4, {"walk", "jog"}, [](int clip, int window) {
                           return clip == 0 ? -2.0 : window == 1 ? -1e300 : -2e6;
                         })});
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("4 of 8 lie below<") && Contains(">-1e6<"));
  CHECK(svg.size() < 20000);
}

TEST_CASE("RecognitionPlot: windows with invalid times are omitted", "[client][cli]") {
  v1::RecognizeResponse layer = WalkThenJog(9);
  layer.mutable_windows(1)->set_start_seconds(std::nan(""));
  layer.mutable_windows(2)->set_end_seconds(kInfinity);
  layer.mutable_windows(3)->set_end_seconds(-1);
  layer.mutable_windows(4)->set_end_seconds(1e300);
  CHECK(LayerProfileFrom(layer).windows.size() == 6);
  ElementsInGroups(RecognitionPlotSvg(Request(), {layer}));
}

TEST_CASE("RecognitionPlot: names are escaped and shortened", "[client][cli]") {
  const std::string label = "<kick> & \"punch\"";
  v1::RecognizeRequest request = Request();
  request.mutable_observation()->mutable_file()->set_file_name(std::string(300, 'f') + "<&>.bvh");
  const std::string svg = RecognitionPlotSvg(
      request, {Answer(9, 20, {label, std::string(500, 'x'), ""},
                       [](int clip, int window) { return -1.0 - (clip + window) % 3; })});
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("&lt;kick&gt; &amp; &quot;punch&quot;: 1 clip<") &&
                      Contains("(no label): 1 clip<") && Contains("xxx...: 1 clip<") &&
                      Contains("fff... in walks<"));
}

TEST_CASE("RecognitionPlot: hundreds of labels share colours, and the legend is limited",
          "[client][cli]") {
  std::vector<std::string> labels;
  for (int i = 0; i < 300; ++i) labels.push_back(fmt::format("label {:03}", i));
  const auto layer = Answer(9, 6, labels, [](int clip, int window) {
    return clip == 290 - window % 2 ? -1.0 : -50.0 - clip;
  });
  const std::string svg = RecognitionPlotSvg(Request(), {layer});
  auto elements = ElementsInGroups(svg);
  int lines = 0;
  for (const auto& [element, count] : elements) lines += element.starts_with("path.clip") * count;
  CHECK(lines == 300);
  CHECK(elements["path.clip best c0"] == 1);
  CHECK(elements["path.clip best c1"] == 1);
  CHECK(elements["path.clip c3"] == 13);  // of 38; the rest is dashed
  CHECK(elements["path.clip c3 d1"] == 13);
  CHECK(elements["path.clip c3 d2"] == 12);
  CHECK(Count(svg, "class=\"sample ") == 24);
  CHECK_THAT(svg, Contains(">and 276 more<"));
  // Winning labels come first, so that their colours differ.
  const auto ranked = PlotLabels({LayerProfileFrom(layer)});
  CHECK(ranked[0].name == "label 289");
  CHECK(ranked[1].name == "label 290");
  CHECK(ranked[2].name == "label 000");
}

TEST_CASE("RecognitionPlot: the size for a long motion is limited by the pixels", "[client][cli]") {
  const auto layer = Answer(9, 20000, {"walk"}, [](int, int window) {
    return window == 7000 ? -900.0 : -5.0 - window % 7;
  });
  const std::string svg = RecognitionPlotSvg(Request(), {layer});
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.clip best c0"] == 1);
  CHECK(elements["rect.winner a0"] == 1);
  CHECK(svg.size() < 60000);
  CHECK(svg == RecognitionPlotSvg(Request(), {layer}));
}

TEST_CASE("RecognitionPlot: a winner is named if its name fits", "[client][cli]") {
  const auto layer = Answer(9, 400, {"walk", "jog"}, [](int clip, int window) {
    return clip == 1 && (window % 2 == 0 || window < 100) ? -1.0 : -2.0 - clip;
  });
  auto elements = ElementsInGroups(RecognitionPlotSvg(Request(), {layer}));
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

TEST_CASE("motiondb recognize --plot: one query for the answer, three for the layers",
          "[client][cli]") {
  FakeServer server;
  server.Answer("Recognize", WalkThenJog(16));
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const std::string plot = (folder / "a.svg").string();
  const auto result = RunMotiondb(
      server.address(), {"recognize", "walks", file, "--top", "1", "--hop", "0.2", "--plot", plot});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK_THAT(result.out, StartsWith("0.00-0.40 s  walk") && EndsWith("wrote " + plot + "\n"));
  CHECK_THAT(ReadFile(plot), StartsWith("<?xml") && EndsWith("</svg>\n"));
  const auto requests = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(requests.size() == 4);
  CHECK(requests[0].method() == v1::METHOD_BEST);
  CHECK(requests[0].top_count() == 1);
  const int layers[] = {0, 0, 8, 4};
  for (int i = 0; i < 4; ++i) {
    CHECK(requests[i].layer() == layers[i]);
    CHECK(requests[i].hop_seconds() == 0.2);
    CHECK(requests[i].observation().file().data() == "HIERARCHY");
    if (i == 0) continue;
    CHECK(requests[i].method() == v1::METHOD_PAPER);
    CHECK(requests[i].top_count() == 0);
  }

  const auto one = RunMotiondb(server.address(), {"recognize", "walks", file, "--layer", "6",
                                                  "--method", "paper", "--json", "--plot", plot});
  CHECK(one.exit_code == 0);
  CHECK(Count(one.out, "\n") == 1);
  const auto all = server.Requests<v1::RecognizeRequest>("Recognize");
  REQUIRE(all.size() == 6);
  CHECK(all[4].method() == v1::METHOD_PAPER);
  CHECK(all[5].layer() == 6);
}

TEST_CASE("motiondb recognize --plot: failures leave no file", "[client][cli]") {
  FakeServer server;
  server.Answer("Recognize", WalkThenJog(16));
  server.Answer("Recognize", WalkThenJog(16));
  server.Fail("Recognize", 9, "the model is gone");
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  const auto wrong =
      RunMotiondb(server.address(), {"recognize", "walks", file, "--plot", "picture.png"});
  CHECK(wrong.exit_code == 1);
  CHECK(wrong.out == "");
  CHECK_THAT(wrong.err, Contains("--plot picture.png") && Contains("FILE.svg"));
  CHECK(server.Requests<v1::RecognizeRequest>("Recognize").empty());
  const auto gone = RunMotiondb(
      server.address(), {"recognize", "walks", file, "--plot", (folder / "a.svg").string()});
  CHECK(gone.exit_code == 1);
  CHECK_THAT(gone.out, StartsWith("0.00-0.40 s  walk") && !Contains("wrote"));
  CHECK_THAT(gone.err, Contains("the model is gone"));
  const auto files = std::distance(std::filesystem::directory_iterator(folder.path()),
                                   std::filesystem::directory_iterator());
  CHECK(files == 1);
  CHECK(RunMotiondb(server.address(), {"recognize", "walks", file, "--method", "luck"}).exit_code ==
        2);
}

TEST_CASE("motiondb predict --method: becomes the request", "[client][cli]") {
  FakeServer server;
  server.Answer("Predict", v1::PredictResponse());
  const TemporaryFolder folder;
  const std::string file = folder.Write("a.bvh", "HIERARCHY").string();
  CHECK(RunMotiondb(server.address(), {"predict", "walks", file, "--json"}).exit_code == 0);
  CHECK(RunMotiondb(server.address(), {"predict", "walks", file, "--json", "--method", "paper"})
            .exit_code == 0);
  const auto requests = server.Requests<v1::PredictRequest>("Predict");
  REQUIRE(requests.size() == 2);
  CHECK(requests[0].method() == v1::METHOD_BEST);
  CHECK(requests[1].method() == v1::METHOD_PAPER);
}

}  // namespace
}  // namespace motiondb::tests::recognition_plot_test
