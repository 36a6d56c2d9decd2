#include "client/cli/plot/recognition_plot.h"

#include <fmt/format.h>
#include <motiondb/v1/query.pb.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "client/cli/plot/picture.h"
#include "client/cli/plot/recognition_plot_answer.h"
#include "tests/client/plot/recognition_answers.h"
#include "tests/client/plot/svg_elements.h"

namespace motiondb::tests::recognition_plot_test {
namespace {

using namespace client;  // NOLINT: the functions under test
using Catch::Contains;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct WindowAnswer {
  std::vector<std::pair<std::string, double>> labels;
  double unknown = -1;  // absent if negative
  std::string clip = "07_01";
  double familiarity = 0.5;
};

// Windows of 0.4 s every 0.1 s.
v1::RecognizeResponse Response(const std::vector<WindowAnswer>& answers) {
  v1::RecognizeResponse response;
  for (const WindowAnswer& answer : answers) {
    const int index = response.windows_size();
    v1::RecognitionWindow& window = *response.add_windows();
    window.set_start_seconds(0.1 * index);
    window.set_end_seconds(0.1 * index + 0.4);
    for (const auto& [name, probability] : answer.labels) {
      v1::LabelProbability& label = *window.add_labels();
      label.set_label(name);
      label.set_probability(probability);
    }
    if (!(answer.unknown < 0)) window.set_unknown_probability(answer.unknown);
    if (!answer.clip.empty()) {
      v1::ClipProbability& clip = *window.add_clips();
      clip.set_clip("databases/walks/clips/" + answer.clip);
      clip.set_label(answer.labels.empty() ? "" : answer.labels.front().first);
      clip.set_log_probability(-5);
    }
    window.set_familiarity(answer.familiarity);
  }
  return response;
}

// Four windows of walk, then four of unknown motion, then two of jog.
v1::RecognizeResponse WalkUnknownJog() {
  std::vector<WindowAnswer> answers;
  for (int i = 0; i < 4; ++i) answers.push_back({{{"walk", 0.7}, {"jog", 0.2}}, 0.1, "07_01", 0.9});
  for (int i = 0; i < 4; ++i) answers.push_back({{{"jog", 0.3}, {"walk", 0.1}}, 0.6, "09_03", 0});
  for (int i = 0; i < 2; ++i) answers.push_back({{{"jog", 0.5}, {"walk", 0}}, 0.5, "09_03", 0.4});
  return Response(answers);
}

std::string Plot(const v1::RecognizeResponse& response, double unknown_threshold = 0.5) {
  return SvgOf(RecognitionPicture(RecognizeWalks(), response, unknown_threshold));
}

// Rectangle of a text, if characters are as wide as in common fonts.
struct TextBox {
  std::string text;
  double left = 0, right = 0, bottom = 0;
};

void AddTexts(const tinyxml2::XMLElement* element, std::vector<TextBox>& boxes) {
  for (; element != nullptr; element = element->NextSiblingElement()) {
    if (std::string(element->Name()) == "text" && !element->Attribute("transform")) {
      constexpr double kCharacterWidth = 7;
      const std::string text = element->GetText() == nullptr ? "" : element->GetText();
      const double width = kCharacterWidth * static_cast<double>(text.size());
      const char* anchor = element->Attribute("text-anchor");
      const double before = anchor == nullptr ? 0 : std::string(anchor) == "end" ? 1 : 0.5;
      const double left = element->DoubleAttribute("x") - before * width;
      boxes.push_back({text, left, left + width, element->DoubleAttribute("y")});
    }
    AddTexts(element->FirstChildElement(), boxes);
  }
}

// Returns the texts that overlap another one.
std::vector<std::string> OverlappingTexts(const std::string& svg) {
  constexpr double kHeight = 11;
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(svg.c_str()) == tinyxml2::XML_SUCCESS);
  std::vector<TextBox> boxes;
  AddTexts(document.RootElement(), boxes);
  std::vector<std::string> overlapping;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (boxes[i].left < boxes[j].right && boxes[j].left < boxes[i].right &&
          std::abs(boxes[i].bottom - boxes[j].bottom) < kHeight) {
        overlapping.push_back(boxes[j].text + " | " + boxes[i].text);
      }
    }
  }
  return overlapping;
}

TEST_CASE("RecognitionPlot: the answer of each window, its clip and its familiarity",
          "[client][cli]") {
  const std::string svg = Plot(WalkUnknownJog());
  auto elements = ElementsInGroups(svg);
  CHECK(elements["path.label a0"] == 1);  // jog
  CHECK(elements["path.label a1"] == 1);  // walk
  CHECK(elements["path.unknown"] == 1);
  CHECK(elements["rect.answer a1"] == 1);
  CHECK(elements["rect.answer unknown"] == 1);
  CHECK(elements["rect.answer a0"] == 1);
  CHECK(elements["text.answer-name unknown-text"] == 1);
  CHECK(elements["rect.clip a1"] == 1);
  CHECK(elements["rect.clip a0"] == 1);
  CHECK(elements["text.clip-name"] == 2);
  CHECK(elements["path.familiarity"] == 1);
  CHECK(elements["rect.hover"] == 10);
  CHECK_THAT(svg, Contains("Recognition: 07_06.amc in walks") &&
                      Contains(">10 windows of 0.4 s, every 0.1 s<") && Contains("above 0.5:"));
  CHECK_THAT(svg, Contains(">walk: 4 windows<") && Contains(">jog: 2 windows<") &&
                      Contains(">unknown: 4 windows<") && Contains(">07_01<") &&
                      Contains("middle of the window (s)"));
  CHECK_THAT(svg, Contains("<title>0.40-0.80 s: jog 0.30, walk 0.10, unknown 0.60; familiarity "
                           "0.00; best clip 09_03</title>"));
  CHECK(Count(svg, "class=\"threshold\"") == 1);
  CHECK(Count(svg, "id=\"hatching-777\"") == 1);
  CHECK_THAT(svg, !Contains("nan") && !Contains("inf") && !Contains("-0.00"));
  CHECK(OverlappingTexts(svg).empty());
  CHECK(svg == Plot(WalkUnknownJog()));
}

TEST_CASE("RecognitionPlot: the areas of a window fill its height", "[client][cli]") {
  const std::string svg = Plot(Response({{{{"walk", 0.75}, {"jog", 0}}, 0.25}}));
  const double top = HeadingHeight(2) + 24, height = 170;
  const std::string low = SvgNumber(top + height), middle = SvgNumber(top + 0.25 * height);
  CHECK_THAT(svg, Contains(fmt::format("class=\"label a1\" d=\"M80.00 {0}V{1}H934.00V{0}H80.00Z\"",
                                       low, middle)));
  CHECK_THAT(svg, Contains(fmt::format("class=\"unknown\" d=\"M80.00 {0}V{1}H934.00V{0}H80.00Z\"",
                                       middle, SvgNumber(top))));
}

TEST_CASE("RecognitionPlot: the threshold decides what is unknown", "[client][cli]") {
  auto none = ElementsInGroups(Plot(WalkUnknownJog(), 0.6));
  CHECK(none.count("rect.answer unknown") == 0);
  CHECK(none["path.unknown"] == 1);
  auto all = ElementsInGroups(Plot(WalkUnknownJog(), 0.05));
  CHECK(all["rect.answer unknown"] == 1);
  CHECK(all.count("rect.answer a0") + all.count("rect.answer a1") == 0);
  CHECK(Count(Plot(WalkUnknownJog(), 1), "class=\"threshold\"") == 0);
  // A label with the same name is another answer.
  auto same =
      ElementsInGroups(Plot(Response({{{{"unknown", 0.2}}, 0.8}, {{{"unknown", 0.9}}, 0.1}})));
  CHECK(same["rect.answer unknown"] == 1);
  CHECK(same["rect.answer a0"] == 1);
}

TEST_CASE("RecognitionPlot: no probability of unknown motion", "[client][cli]") {
  v1::RecognizeResponse response = Response({{{{"walk", 1}}}, {{{"walk", 0.5}, {"jog", 0.5}}}});
  const std::string svg = Plot(response);
  auto elements = ElementsInGroups(svg);
  CHECK(elements["rect.answer a1"] == 1);
  CHECK_THAT(svg, Contains(">no probability of unknown motion<") && !Contains("\"threshold\"") &&
                      !Contains(">unknown"));
  response.set_calibration(v1::CALIBRATION_ONE_SUBJECT);
  CHECK_THAT(Plot(response), Contains("fewer than two subjects"));
  v1::RecognizeRequest paper = RecognizeWalks();
  paper.set_method(v1::METHOD_PAPER);
  CHECK_THAT(SvgOf(RecognitionPicture(paper, response, 0.5)),
             Contains("only the tree and its graphs") && !Contains("subjects"));
}

TEST_CASE("RecognitionPlot: no windows, no labels, no clips", "[client][cli]") {
  const std::string nothing = Plot(v1::RecognizeResponse());
  CHECK(ElementsInGroups(nothing).empty());
  CHECK(Count(nothing, ">no windows<") == 2);  // heading and frame
  const std::string svg = Plot(Response({{{}, -1, "", 0}, {{}, -1, "", 0}}));
  auto elements = ElementsInGroups(svg);
  CHECK(elements.count("path.familiarity") == 1);
  CHECK(elements["rect.hover"] == 2);
  CHECK(elements.size() == 2);
  CHECK_THAT(svg, Contains(">no labels<"));
}

TEST_CASE("RecognitionPlot: values that are not finite are omitted", "[client][cli]") {
  v1::RecognizeResponse response =
      Response({{{{"walk", kNan}, {"jog", kInfinity}}, kNan, "07_01", kNan},
                {{{"walk", 0.9}, {"jog", -kInfinity}}, kInfinity, "07_01", 0.5},
                {{{"walk", 40}, {"jog", 1e300}}, 1e300, "07_01", 1e300},
                {{{"walk", -3}, {"jog", 0.5}}, 0.5, "07_01", -kInfinity}});
  response.mutable_windows(1)->mutable_clips(0)->set_log_probability(-kInfinity);
  const std::string svg = Plot(response);
  auto elements = ElementsInGroups(svg);
  CHECK(elements["rect.clip a1"] == 2);
  CHECK(elements["path.familiarity"] == 1);
  CHECK(elements["rect.answer unknown"] == 1);  // infinite and 1e300 are above the threshold
  CHECK_THAT(svg, !Contains("=\"nan") && !Contains("=\"inf") && !Contains(" nan\"") &&
                      !Contains("Vnan") && !Contains("Vinf"));
  const RecognitionAnswer answer = RecognitionAnswerFrom(response, 0.5);
  for (const AnswerColumn& column : answer.columns) {
    double sum = column.unknown;
    for (const double probability : column.probabilities) sum += probability;
    CHECK(sum >= 0);
    CHECK(sum <= 1 + 1e-9);
  }
  response.mutable_windows(0)->set_start_seconds(kNan);
  response.mutable_windows(1)->set_end_seconds(1e300);
  CHECK(RecognitionAnswerFrom(response, 0.5).columns.size() == 2);
}

TEST_CASE("RecognitionPlot: names are escaped and shortened", "[client][cli]") {
  const std::string label = "<kick> & \"punch\"";
  v1::RecognizeRequest request = RecognizeWalks();
  request.mutable_observation()->mutable_file()->set_file_name(std::string(300, 'f') + "<&>.bvh");
  std::vector<WindowAnswer> answers;
  for (const std::string& name : {label, std::string(500, 'x'), std::string()}) {
    for (int i = 0; i < 4; ++i) answers.push_back({{{name, 0.9}}, 0.1, "<clip>" + name});
  }
  const std::string svg = SvgOf(RecognitionPicture(request, Response(answers), 0.5));
  ElementsInGroups(svg);
  CHECK_THAT(svg, Contains("&lt;kick&gt; &amp; &quot;punch&quot;: 4 windows<") &&
                      Contains("(no label): 4 windows<") && Contains("xxx...: 4 windows<") &&
                      Contains("&lt;clip&gt;") && Contains("fff... in walks<"));
  CHECK(OverlappingTexts(svg).empty());
}

TEST_CASE("RecognitionPlot: 200 clips and 30 labels", "[client][cli]") {
  std::vector<WindowAnswer> answers;
  for (int w = 0; w < 200; ++w) {
    WindowAnswer answer;
    for (int i = 0; i < 30; ++i) {
      const int label = (w / 10 + i) % 30;  // 20 labels win
      answer.labels.emplace_back(fmt::format("rather long label {:02}", label), i == 0 ? 0.6
                                                                                : i == 29
                                                                                    ? 0.04
                                                                                    : 0.3 / 28);
    }
    answer.unknown = 0.06;
    answer.clip = fmt::format("HDM_bd_squat1Reps_{:03}_120", w);
    answers.push_back(answer);
  }
  const std::string svg = Plot(Response(answers));
  auto elements = ElementsInGroups(svg);
  int labels = 0, answer_parts = 0, clip_parts = 0;
  for (const auto& [element, count] : elements) {
    labels += element.starts_with("path.label ") * count;
    answer_parts += element.starts_with("rect.answer ") * count;
    clip_parts += element.starts_with("rect.clip ") * count;
  }
  CHECK(labels == 20);
  CHECK(elements["path.others"] == 1);
  CHECK(answer_parts == 20);
  CHECK(clip_parts == 200);
  CHECK(elements.count("text.clip-name") == 0);
  CHECK_THAT(svg, Contains(">10 other labels<") && Contains(">rather long label 07: 10 windows<"));
  CHECK(OverlappingTexts(svg).empty());
}

TEST_CASE("RecognitionPlot: clips whose names do not fit have numbers", "[client][cli]") {
  std::vector<WindowAnswer> answers;
  for (int w = 0; w < 60; ++w) {
    const int clip = w < 20 ? 0 : w - 19;  // wide, then narrow parts
    answers.push_back({{{"squat", 1}}, -1, fmt::format("HDM_bd_squat1Reps_{:03}_120", clip), 0.5});
  }
  const std::string svg = Plot(Response(answers));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["rect.clip a0"] == 41);
  CHECK(elements["text.clip-name"] == 1);  // 14 pixels are too narrow for a number
  CHECK_THAT(svg, !Contains(">#"));

  answers.resize(22);
  const std::string numbered = Plot(Response(answers));
  CHECK(ElementsInGroups(numbered)["text.clip-name"] == 3);
  CHECK_THAT(numbered, Contains(">HDM_bd_squat1Reps_000_120<") && Contains(">#2<") &&
                           Contains(">#3<") && !Contains(">#1<") &&
                           Contains(">HDM_bd_squat1Reps_001_120: 1 window<"));
  CHECK(OverlappingTexts(numbered).empty());
}

TEST_CASE("RecognitionPlot: the size for a long motion is limited", "[client][cli]") {
  std::vector<WindowAnswer> answers;
  for (int w = 0; w < 20000; ++w) {
    answers.push_back({{{w % 3 == 0 ? "walk" : "jog", 0.8}, {w % 3 == 0 ? "jog" : "walk", 0.1}},
                       w % 7 < 5 ? 0.1 : 0.9,
                       fmt::format("clip-{}", w % 40),
                       0.01 * (w % 100)});
  }
  const std::string svg = Plot(Response(answers));
  auto elements = ElementsInGroups(svg);
  CHECK(elements["rect.hover"] == 426);
  CHECK_THAT(
      svg, Contains("each column is the mean of 47 windows") && Contains("first of 47 windows: "));
  CHECK(svg.size() < 300000);
  const RecognitionAnswer answer = RecognitionAnswerFrom(Response(answers), 0.5);
  CHECK(answer.unknown_windows + answer.labels[0].windows_won + answer.labels[1].windows_won ==
        20000);
  CHECK(answer.columns[0].answer == 0);  // jog, in most windows
  CHECK(answer.columns[0].cell.end == answer.columns[1].cell.start);
}

}  // namespace
}  // namespace motiondb::tests::recognition_plot_test
