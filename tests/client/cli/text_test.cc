#include <google/protobuf/descriptor.h>
#include <motiondb/v1/clip.pb.h>
#include <motiondb/v1/database.pb.h>
#include <motiondb/v1/model.pb.h>
#include <motiondb/v1/observation.pb.h>
#include <motiondb/v1/observe.pb.h>
#include <motiondb/v1/plan.pb.h>
#include <motiondb/v1/query.pb.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>

#include "client/cli/database_text.h"
#include "client/cli/query/estimation_prediction_text.h"
#include "client/cli/query/recognition_text.h"
#include "client/cli/resource_name.h"
#include "client/cli/terminal/print.h"
#include "client/cli/terminal/terminal.h"
#include "tests/support/packed_floats.h"

namespace motiondb::tests::text_test {
namespace {

using namespace client;  // NOLINT: the functions under test

TEST_CASE("ResourceName: short and full names are equivalent", "[client][cli]") {
  CHECK(DatabaseName("walks") == "databases/walks");
  CHECK(DatabaseName("databases/walks") == "databases/walks");
  CHECK(ClipName("walks", "07_01") == "databases/walks/clips/07_01");
  CHECK(ClipName("walks", "databases/walks/clips/07_01") == "databases/walks/clips/07_01");
  CHECK(SkeletonName("walks", "07") == "databases/walks/skeletons/07");
  CHECK(OperationName("17") == "operations/17");
  CHECK(ShortName("databases/walks/clips/07_01") == "07_01");
  CHECK(ShortName("07_01") == "07_01");
}

TEST_CASE("CountText: singular and plural", "[client][cli]") {
  CHECK(CountText(0, "clip") == "0 clips");
  CHECK(CountText(1, "clip") == "1 clip");
  CHECK(CountText(2, "clip") == "2 clips");
}

TEST_CASE("RecognitionText: a line for each window or answer, then the share of each label",
          "[client][cli]") {
  v1::RecognizeResponse response;
  for (int i = 0; i < 3; ++i) {
    auto* window = response.add_windows();
    window->set_start_seconds(0.1 * i);
    window->set_end_seconds(0.1 * i + 0.4);
    window->set_familiarity(0.71);
    auto* first = window->add_labels();
    first->set_label(i == 1 ? "jog" : "walk");
    first->set_probability(0.98);
    auto* second = window->add_labels();
    second->set_label(i == 1 ? "walk" : "jog");
    second->set_probability(i == 2 ? 1e-9 : 0.02);
    window->add_clips()->set_clip("databases/walks/clips/07_01");
  }
  const std::string shares = "walk 67 % (2 of 3 windows), jog 33 % (1 of 3 windows)\n";
  CHECK(WithStyles(RecognitionText(response, 0.5, Windows::kEvery), false) ==
        "FROM (s)  TO (s)  ANSWER  PROBABILITY  FAMILIARITY  BEST CLIP\n"
        "    0.00    0.40  walk           0.98         0.71  07_01\n"
        "    0.10    0.50  jog            0.98         0.71  07_01\n"
        "    0.20    0.60  walk           0.98         0.71  07_01\n" +
            shares);
  // Successive windows with the same answer are one row, with means and the most frequent clip.
  auto* next = response.mutable_windows(1);
  next->mutable_labels(0)->set_label("walk");
  next->mutable_labels(0)->set_probability(0.5);
  next->set_familiarity(0.11);
  next->mutable_clips(0)->set_clip("databases/walks/clips/02_01");
  CHECK(WithStyles(RecognitionText(response, 0.5, Windows::kMerged), false) ==
        "FROM (s)  TO (s)  WINDOWS  ANSWER  PROBABILITY  FAMILIARITY  BEST CLIP\n"
        "    0.00    0.60        3  walk           0.82         0.51  07_01\n"
        "walk 100 % (3 of 3 windows)\n");
}

TEST_CASE("RecognitionText: reports that nothing was recognized", "[client][cli]") {
  v1::RecognizeResponse response;
  CHECK(RecognitionText(response, 0.5, Windows::kMerged) == "nothing recognized\n");
  response.add_windows();
  CHECK_THAT(RecognitionText(response, 0.5, Windows::kMerged),
             Catch::Contains("none") && Catch::EndsWith("nothing recognized\n"));
}

TEST_CASE("EstimationText: paths are runs of node x frames", "[client][cli]") {
  v1::EstimateResponse response;
  response.set_layer(12);
  response.set_frame_rate_hz(60);
  response.mutable_state()->set_node_id(13);
  response.mutable_state()->set_probability(0.8312);
  auto* path = response.add_paths();
  path->set_log_probability(-123.456);
  for (const int node : {12, 12, 12, 13, 12, 13, 13}) path->add_node_ids(node);
  const std::string text = EstimationText(response, {});
  CHECK_THAT(text, Catch::StartsWith("state: node 13 of layer 12, probability 0.831\n"));
  CHECK_THAT(text, Catch::Contains("7 frames, 0.12 s at 60 Hz, log probability -123.46"));
  CHECK_THAT(text, Catch::EndsWith("  12x3 13x1 12x1 13x2\n"));
}

TEST_CASE("EstimationText: positions and expected errors of missing markers", "[client][cli]") {
  v1::EstimateResponse response;
  auto& frame = *response.add_filled_frames();
  frame.set_seconds(1.2);
  frame.set_marker_positions(Pack({0.1F, 0.2F, 0.3F, 1.0F, -2.0F, 0.5F}));
  frame.set_marker_deviations(Pack({0, 0.012F}));
  frame.set_marker_count(2);
  const std::string text = EstimationText(response, {"Pelvis", "LWrist"});
  CHECK_THAT(text, Catch::Contains("filled in at 1.20 s"));
  CHECK_THAT(text, Catch::Contains("LWrist") && Catch::Contains("1.000  -2.000  0.500") &&
                       Catch::Contains("0.012"));
  CHECK_THAT(text, !Catch::Contains("Pelvis"));
}

TEST_CASE("EstimationText: a long path is wrapped", "[client][cli]") {
  v1::EstimateResponse response;
  auto* path = response.add_paths();
  for (int i = 0; i < 200; ++i) path->add_node_ids(i);
  const std::string text = EstimationText(response, {});
  size_t longest = 0;
  for (size_t begin = 0, end; begin < text.size(); begin = end + 1) {
    end = text.find('\n', begin);
    longest = std::max(longest, end - begin);
  }
  CHECK(longest <= 100);
  CHECK_THAT(text, Catch::Contains(" 199x1\n"));
}

TEST_CASE("PredictionText: next nodes, and the middle of the body", "[client][cli]") {
  v1::PredictResponse response;
  response.set_at_seconds(1.2);
  auto* next = response.add_next_nodes();
  next->set_node_id(58);
  next->set_probability(0.61);
  for (int i = 0; i < 6; ++i) next->add_clips("databases/walks/clips/c" + std::to_string(i));
  auto* frame = response.add_horizons();
  frame->set_seconds(0.08);
  frame->set_confidence(0.9);
  frame->set_marker_positions(Pack({1, 2, 3, 3, 4, 5}));
  const std::string text = WithStyles(PredictionText(response, {}), false);
  CHECK_THAT(text, !Catch::Contains("extrapolate") && !Catch::Contains("ACTUAL"));
  CHECK_THAT(text, Catch::StartsWith("from 1.20 s"));
  CHECK_THAT(text, Catch::Contains("NEXT NODE  PROBABILITY  AS IN\n"
                                   "       58         0.61  c0 c1 c2 c3 and 2 more\n"));
  CHECK_THAT(text, Catch::Contains("AHEAD (s)  WITHIN 5 cm  MIDDLE X (m)  Y (m)  Z (m)\n"
                                   "     0.08         0.90         2.000  3.000  4.000\n"));
}

TEST_CASE("PredictionText: notes of extrapolation", "[client][cli]") {
  v1::PredictResponse response;
  response.set_unknown_probability(0.87);
  auto* frame = response.add_horizons();
  frame->set_seconds(3);
  frame->set_extrapolated(true);
  CHECK_THAT(PredictionText(response, {}),
             Catch::Contains("unknown 0.87: the motion before that time") &&
                 Catch::Contains("extrapolated from 3.00 s: no similar stored motion"));
  CHECK_THAT(PredictionText(response, {.unknown_threshold = 0.9}), !Catch::Contains("unknown"));
}

TEST_CASE("PredictionText: the error against the motion that follows", "[client][cli]") {
  PredictionView view;
  view.motion_m = {0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0,   // 0.0, 0.1 s
                   0, 0, 3, 1, 0, 3, 0, 0, 0, 0, 0, 0};  // 0.2, 0.3 s
  view.frame_rate_hz = 10;
  v1::PredictResponse response;
  response.set_at_seconds(0.1);
  for (const double seconds : {0.1, 1.0}) {
    auto* frame = response.add_horizons();
    frame->set_seconds(seconds);
    frame->set_expected_error_m(2);
    frame->set_marker_positions(Pack({0, 0, 0, 1, 0, 1}));  // 3 m and 2 m away from the truth
  }
  const std::string text = WithStyles(PredictionText(response, view), false);
  CHECK_THAT(text, Catch::Contains("AHEAD (s)  ERROR (m)  ACTUAL (m)  MIDDLE X (m)"));
  CHECK_THAT(text, Catch::Contains("     0.10      2.000       2.500 ") &&
                       Catch::Contains("     1.00      2.000             "));
}

TEST_CASE("DescriptionText: statistics of Table I and nodes of each layer", "[client][cli]") {
  v1::DatabaseStatistics description;
  description.set_name("databases/walks");
  description.set_frame_count(11969);
  description.set_clip_count(6);
  description.set_stored_clip_count(7);
  description.set_layer_count(2);
  description.add_nodes_per_layer(1);
  description.add_nodes_per_layer(2);
  const std::string text = WithStyles(DescriptionText(description), false);
  CHECK_THAT(text, Catch::Contains("frames                11969\n"));
  CHECK_THAT(text, Catch::Contains("model version          none\n"));
  CHECK_THAT(text, Catch::Contains("7 clips are stored; 6 of them in the model\n"));
  CHECK_THAT(text, Catch::Contains("LAYER  NODES\n    1      1\n    2      2\n"));
  CHECK_THAT(text, !Catch::Contains("calibration"));
}

TEST_CASE("DescriptionText, RecognitionText, PredictionText: kind of calibration",
          "[client][cli]") {
  v1::DatabaseStatistics description;
  description.set_calibration(v1::CALIBRATION_OWN);
  CHECK_THAT(DescriptionText(description),
             Catch::Contains("calibration             own\n") && !Catch::Contains("is new"));
  description.set_calibration(v1::CALIBRATION_TYPICAL);
  CHECK_THAT(DescriptionText(description),
             Catch::Contains("calibration          typical\n") &&
                 Catch::Contains("the model is new: it uses a typical calibration"));
  const std::string previous =
      "the model is new: it uses the previous model's calibration until its own is complete, and "
      "is "
      "stored then\n";
  v1::RecognizeResponse recognition;
  CHECK_THAT(RecognitionText(recognition, 0.5, Windows::kMerged), !Catch::Contains("calibration"));
  recognition.set_calibration(v1::CALIBRATION_PREVIOUS);
  CHECK_THAT(RecognitionText(recognition, 0.5, Windows::kMerged), Catch::EndsWith(previous));
  v1::PredictResponse prediction;
  prediction.set_calibration(v1::CALIBRATION_PREVIOUS);
  CHECK_THAT(PredictionText(prediction, {}), Catch::EndsWith(previous));
}

TEST_CASE("DescriptionText, ClipsTable: glitch policy and found glitches", "[client][cli]") {
  v1::DatabaseStatistics description;
  description.set_glitches(v1::GLITCHES_KEEP);
  CHECK_THAT(DescriptionText(description), Catch::Contains("glitches               keep\n"));
  v1::Clip clip;
  clip.set_name("databases/walks/clips/a");
  clip.set_glitches("repaired (1): frame 101: all markers jump");
  CHECK_THAT(ClipsTable({clip}).ToString(),
             Catch::Contains("GLITCHES") && Catch::Contains("frame 101: all markers jump"));
}

TEST_CASE("DescriptionText, UnderivedText: clips that could not be derived again",
          "[client][cli]") {
  v1::DatabaseStatistics description;
  CHECK_THAT(DescriptionText(description), !Catch::Contains("derived"));
  description.set_underived_clip_count(2);
  auto* const clip_a = description.add_underived_clips();
  clip_a->set_name("databases/walks/clips/a");
  clip_a->set_reason("a.bvh:12: expected a number\x1b[2J");
  const std::string text = DescriptionText(description);
  CHECK_THAT(text, Catch::Contains("2 clips could not be derived again from their files:\n"
                                   "  a: a.bvh:12: expected a number") &&
                       Catch::Contains("\n  ...\n"));
  CHECK(text.find('\x1b') == std::string::npos);
  v1::Clip clip;
  clip.set_name("databases/walks/clips/a");
  CHECK(UnderivedText(std::vector{clip}).empty());
  clip.set_derive_error("chunk 0 is corrupt");
  CHECK(UnderivedText(std::vector{clip}) == "\nnot derived again:\n  a: chunk 0 is corrupt\n");
}

TEST_CASE("IngestedClipText: the report of the reader is below its clip", "[client][cli]") {
  v1::Clip clip;
  clip.set_name("databases/walks/clips/07_01");
  clip.set_source_report("unit: 1/0.45 inch\nup: y");
  const std::string text = IngestedClipText(clip);
  CHECK_THAT(text, Catch::StartsWith("07_01  (no label)  "));
  CHECK_THAT(text, Catch::EndsWith("\n    unit: 1/0.45 inch\n    up: y\n"));
}

TEST_CASE("Json: proto field names and default values, on one line", "[client][cli]") {
  v1::RecognitionWindow window;
  window.add_clips()->set_log_probability(-std::numeric_limits<double>::infinity());
  const std::string json = JsonLine(window);
  CHECK_THAT(json, Catch::Contains("\"start_seconds\":0") && Catch::Contains("\"labels\":[]") &&
                       Catch::Contains("\"log_probability\":\"-Infinity\""));
  CHECK(json.find('\n') == std::string::npos);
  CHECK(JsonString("a\"b\n") == R"("a\"b\n")");
}

TEST_CASE("Json: packed floats are numbers, outcomes of plans are words", "[client][cli]") {
  v1::PredictedFrame frame;
  frame.set_marker_positions(Pack({0.1F, -2.0F, std::nanf("")}));
  CHECK_THAT(JsonLine(frame), Catch::Contains(R"("marker_positions":[0.1,-2,"NaN"])"));
  v1::PlanResponse plan;
  plan.set_outcome(v1::PLAN_OUTCOME_EXACT);
  plan.set_missing(R"("marker_positions":"AAAA")");
  CHECK_THAT(JsonLine(plan), Catch::Contains(R"("outcome":"EXACT")") &&
                                 Catch::Contains(R"(\"marker_positions\":\"AAAA\")"));
  v1::LabelProbability label;
  label.set_label("PLAN_OUTCOME_EXACT");  // a user's own word stays
  CHECK_THAT(JsonLine(label), Catch::Contains(R"("label":"PLAN_OUTCOME_EXACT")"));
}

TEST_CASE("Json: every bytes field is numbers, but for those that hold a file", "[client][cli]") {
  const std::set<std::string> files = {"data", "skeleton_data", "urdf"};
  int fields = 0;
  for (const auto* file :
       {v1::PlanResponse::descriptor()->file(), v1::PredictResponse::descriptor()->file(),
        v1::Model::descriptor()->file(), v1::Observation::descriptor()->file(),
        v1::ObserveResponse::descriptor()->file()}) {
    for (int m = 0; m < file->message_type_count(); ++m) {
      const auto* type = file->message_type(m);
      const std::unique_ptr<google::protobuf::Message> message(
          google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
      for (int f = 0; f < type->field_count(); ++f) {
        const auto* field = type->field(f);
        if (field->type() != google::protobuf::FieldDescriptor::TYPE_BYTES) continue;
        ++fields;
        message->GetReflection()->SetString(message.get(), field, std::string(4, '\0'));
        INFO(field->full_name());
        CHECK((JsonLine(*message).find("\"" + field->name() + "\":[0]") == std::string::npos) ==
              files.contains(field->name()));
      }
    }
  }
  CHECK(fields > 10);
}

TEST_CASE("ProgressLine: fits the width of the terminal", "[client][cli]") {
  CHECK(ProgressLine(0.5, "tree", 80) == "[############............]  50 %  tree");
  CHECK(ProgressLine(7, "", 80) == "[########################] 100 %  ");
  CHECK(ProgressLine(0.5, "a long name of a file", 40).size() == 39);
}

}  // namespace
}  // namespace motiondb::tests::text_test
